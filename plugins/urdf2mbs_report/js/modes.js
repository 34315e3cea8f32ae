// The modes of a robot about an equilibrium: a list, and the motion of the one that is chosen.
//
// In a mode with the eigenvalue s, each joint moves as q(t) = q0 + a Re(shape exp(i w t)); the page
// shows it without its damping, with an amplitude and a period that the user chooses.

import {byId, createElement, data, jointByName} from "./basics.js";
import {onSpace} from "./player.js";
import {closeShownLoops, jointPositions, showPositions} from "./positions.js";
import {makeRoving} from "./roving.js";
import {formatWithUnit, onUnitChange} from "./units.js";

// data.modes is made by describe_modes in commands/modes.py: positions (q0 of all joints), chosen,
// and modes [{number, frequency, damping, time, amplitudes, phases, joints}]
const shownMode = {index: 0, phase: 0, isPlaying: false};

const getMode = () => data.modes.modes[shownMode.index];

// The joint that moves most, by which the amplitude is measured.
const getFirstJoint = () => jointByName.get(getMode().joints[0]).joint;

function drawMode() {
  const {amplitudes, phases} = getMode(), amplitude = +byId("amplitude").value;
  Object.entries(data.modes.positions).forEach(([name, position], k) => {
    const move = amplitudes[k] * Math.cos(shownMode.phase + phases[k]);
    jointPositions.set(name, position + amplitude * move);
  });
  closeShownLoops();
  showPositions();
}

// The time of an oscillation on the screen (s).
function getPeriod() {
  const period = byId("period").value, {frequency} = getMode();
  return period === "real" && frequency > 0 ? 1 / frequency : +period || 2;
}

function playMode(isOn) {
  shownMode.isPlaying = isOn;
  byId("play").textContent = isOn ? "Pause" : "Play";
  if (!isOn) return;
  let previousTime = performance.now();
  const step = (currentTime) => {  // ms
    if (!shownMode.isPlaying) return;
    const elapsed = Math.max(currentTime - previousTime, 0) / 1000;
    previousTime = currentTime;
    shownMode.phase = (shownMode.phase + 2 * Math.PI * elapsed / getPeriod()) % (2 * Math.PI);
    drawMode();
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

// Show the mode at a phase of its oscillation (rad).
export function showPhase(phase) {
  shownMode.phase = phase;
  drawMode();
}

// Show a mode at its largest amplitude.
function chooseMode(index) {
  Object.assign(shownMode, {index, phase: 0});
  document.querySelectorAll("#mode-table tbody tr").forEach((row, k) => {
    row.classList.toggle("selected", k === index);
    row.ariaSelected = k === index;
  });
  describeAmplitude();
  drawMode();
}

function describeAmplitude() {
  const {name, type} = getFirstJoint();
  byId("amplitude-value").textContent = `${formatWithUnit(type, +byId("amplitude").value)} of ${name}`;
}

function makeModeRow(mode, index) {
  const row = createElement("tr", "selectable");
  const addCell = (text, className = "") => row.append(createElement("td", className, text));
  addCell(mode.number, "n");
  addCell(mode.frequency > 0 ? `${+mode.frequency.toPrecision(4)}` : "-", "n");
  addCell(mode.frequency > 0 ? `${+mode.damping.toPrecision(4)}` : mode.time, "n");
  addCell(mode.joints.join(", "));
  row.onclick = () => chooseMode(index);
  row.onkeydown = (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    chooseMode(index);
  };
  return row;
}

export function makeModes() {
  const table = byId("mode-table");
  if (!data.modes.modes.length) return;  // no mode moves a joint
  table.role = "grid";
  table.tBodies[0].append(...data.modes.modes.map(makeModeRow));
  makeRoving(table, "tbody tr");
  byId("play").onclick = () => playMode(!shownMode.isPlaying);
  byId("amplitude").oninput = () => { describeAmplitude(); drawMode(); };
  onUnitChange(describeAmplitude);
  onSpace(byId("play"));
  chooseMode(data.modes.chosen);
}
