// The motion of a simulated project: play, the trail of a body, arrows of forces, and curves.

import {makeForceArrows} from "./arrows.js";
import {bodyByName, byId, data, decodeBase64, vector} from "./basics.js";
import {comparison} from "./comparison.js";
import {computeMbsPoses} from "./kinematics.js";
import {MARK_COLORS} from "./marks.js";
import {jointPositions, onPositionsChange, updatePositions} from "./positions.js";
import {scene} from "./scene.js";
import {selection} from "./selection.js";

// time (s), isPlaying, and the functions seek(time) and play(isOn).
export const player = {time: 0, isPlaying: false, seek: null, play: null};

// The results by frame: see read_motion in motion.py.
const motion = {joints: [], forces: [], times: [], positions: [], loads: [], energies: []};
const MAX_CURVES = 8;

function unpackMotion() {
  const decodeFloats = (text) => new Float32Array(decodeBase64(text).buffer);
  const {joints, forces, time, q, F, E} = data.motion;
  Object.assign(motion, {
    joints,
    forces: forces.map(([body, name, isPush]) => ({body, name, isPush})),
    times: decodeFloats(time), positions: decodeFloats(q), loads: decodeFloats(F),
    energies: decodeFloats(E),
  });
}

// The frame at or before a time.
const findFrame = (time) =>
  Math.max(0, motion.times.findLastIndex((frameTime) => frameTime <= time + 1e-6));
const getPosition = (frame, joint) => motion.positions[frame * motion.joints.length + joint];
const getForce = (frame, force) => getLoad(frame, force, 0);  // N, in the axes of the base
const getForcePoint = (frame, force) => getLoad(frame, force, 3);  // m, in the frame of the body
const getLoad = (frame, force, offset) =>
  vector().fromArray(motion.loads, 6 * (frame * motion.forces.length + force) + offset);
const getKineticEnergy = (frame) => motion.energies[2 * frame];  // J
const getPotentialEnergy = (frame) => motion.energies[2 * frame + 1];  // J

// --- the trail of the selected body ---

let trail = null, trailBody;

function updateTrail() {
  const isShown = byId("trail").checked && bodyByName.has(selection.body);
  const body = isShown ? selection.body : undefined;
  if (body === trailBody) return;
  trailBody = body;
  if (trail) scene.remove(trail);
  trail = null;
  if (body === undefined) return;
  const points = Array.from(motion.times, (_, frame) => {
    const positions = motion.joints.map((name, joint) => [name, getPosition(frame, joint)]);
    const {bodies} = computeMbsPoses(new Map(positions));
    return vector().setFromMatrixPosition(bodies.get(body));
  });
  trail = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
    new THREE.LineBasicMaterial({color: MARK_COLORS.stops}));
  scene.add(trail);
}

// --- curves over time ---

// What can be drawn: {name, curves}; the curves of a plot are below each other.
let plots = [];

function makeCurve(name, getValue) {
  const values = Array.from(motion.times, (_, frame) => getValue(frame));
  const low = values.reduce((a, b) => Math.min(a, b));
  const high = values.reduce((a, b) => Math.max(a, b));
  return {name, values, low, high};
}

function makePlots() {
  const jointCurves = motion.joints.map((name, joint) =>
    makeCurve(name, (frame) => getPosition(frame, joint)));
  const forceCurves = motion.forces.map(({name}, force) =>
    makeCurve(`|${name}| (N)`, (frame) => getForce(frame, force).length()));
  const energyCurves = !motion.energies.length ? [] : [
    makeCurve("kinetic (J)", getKineticEnergy),
    makeCurve("potential (J)", getPotentialEnergy),
    makeCurve("sum (J)", (frame) => getKineticEnergy(frame) + getPotentialEnergy(frame)),
  ];
  const change = ({low, high}) => high - low;
  const selectLargest = (curves) => curves.filter((curve) => change(curve) > 1e-6)
    .sort((a, b) => change(b) - change(a)).slice(0, MAX_CURVES);
  plots = [
    {name: "Joints", curves: selectLargest(jointCurves)},
    {name: "Forces", curves: selectLargest(forceCurves)},
    {name: "Energy", curves: energyCurves},
  ].filter(({curves}) => curves.length);
  plots.push(...[...jointCurves, ...forceCurves].map((curve) => ({name: curve.name, curves: [curve]})));
  plots.forEach(({name}, index) => byId("curve").add(new Option(name, index)));
}

function drawPlot() {
  const canvas = byId("curves"), pen = canvas.getContext("2d"), {curves} = plots[byId("curve").value];
  const width = canvas.width = canvas.clientWidth || 600;
  const rowHeight = curves.length > 1 ? 48 : 150;
  canvas.height = rowHeight * curves.length;
  canvas.style.height = `${canvas.height}px`;
  const textColor = getComputedStyle(canvas).color, frame = findFrame(player.time);
  const [first, last] = [motion.times[0], motion.times[motion.times.length - 1]];
  const computeX = (time) => (time - first) / (last - first || 1) * width;
  curves.forEach(({name, values, low, high}, row) => {
    const top = rowHeight * row, bottom = top + rowHeight - 5;
    const computeY = (value) => bottom - (value - low) / (high - low || 1) * (rowHeight - 22);
    pen.strokeStyle = `hsl(${row * 137.5 % 360} 60% 48%)`;
    pen.beginPath();
    values.forEach((value, k) => pen.lineTo(computeX(motion.times[k]), computeY(value)));
    pen.stroke();
    pen.fillStyle = textColor;
    pen.textAlign = "left";
    pen.fillText(`${name}: ${+values[frame].toPrecision(4)}`, 4, top + 11);
    pen.textAlign = "right";
    pen.fillText(`${+low.toPrecision(4)} ... ${+high.toPrecision(4)}`, width - 4, top + 11);
  });
  pen.strokeStyle = textColor;
  pen.strokeRect(computeX(player.time), 0, 0.5, canvas.height);
}

// --- the player ---

export function makePlayer() {
  unpackMotion();
  makePlots();
  const {joints, forces, times} = motion;
  const first = times[0], last = times[times.length - 1];
  const scrub = byId("scrub"), button = byId("play"), canvas = byId("curves");
  const drawArrow = makeForceArrows(forces.map(({isPush}) => isPush));
  let largestForce = 1e-9;
  times.forEach((_, frame) => forces.forEach((__, force) => {
    largestForce = Math.max(largestForce, getForce(frame, force).length());
  }));

  // A slider leaves the frame of the motion, and its forces with it.
  onPositionsChange(() => forces.forEach((_, force) =>
    drawArrow(force, null, null, vector(), largestForce)));

  player.seek = (time) => {
    player.time = Math.min(Math.max(time, first), last);
    const frame = findFrame(player.time);
    joints.forEach((name, joint) => jointPositions.set(name, getPosition(frame, joint)));
    updatePositions();
    forces.forEach(({body}, force) => {
      const bodyPose = comparison.mbs.bodies.get(body), point = getForcePoint(frame, force);
      drawArrow(force, bodyPose, point, getForce(frame, force), largestForce);
    });
    updateTrail();
    scrub.value = player.time;
    byId("clock").textContent = `${player.time.toFixed(2)} s`;
    drawPlot();
  };

  player.play = (isOn) => {
    player.isPlaying = isOn;
    button.textContent = isOn ? "Pause" : "Play";
    if (!isOn) return;
    if (player.time >= last) player.seek(first);
    let previousTime = performance.now();
    const step = (currentTime) => {  // ms
      if (!player.isPlaying) return;
      const elapsed = Math.max(currentTime - previousTime, 0) / 1000;
      let next = player.time + elapsed * byId("speed").value;
      previousTime = currentTime;
      if (next >= last && byId("repeat").checked) next = first;
      player.seek(next);
      if (player.time >= last && !byId("repeat").checked) player.play(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  };

  button.onclick = () => player.play(!player.isPlaying);
  Object.assign(scrub, {min: first, max: last});
  scrub.oninput = () => { player.play(false); player.seek(+scrub.value); };
  canvas.onclick = (event) =>
    player.seek(first + event.offsetX / canvas.clientWidth * (last - first));
  byId("curve").onchange = byId("trail").onchange = () => player.seek(player.time);
  document.addEventListener("keydown", (event) => {
    // A button, a field or a row uses the space itself.
    if (event.key !== " " || !["BODY", "CANVAS"].includes(event.target.tagName)) return;
    event.preventDefault();
    button.click();
  });
  byId("player").hidden = false;
  player.seek(first);
}
