// The motion of a simulated project: play, the trail of a body, arrows of forces, and curves.

import {makeForceArrows} from "./arrows.js";
import {bodyByName, byId, data, decodeBase64, jointByName, vector} from "./basics.js";
import {fitMotion, followRobot} from "./camera.js";
import {comparison} from "./comparison.js";
import {drawPlot, findPlotTime, makePlots} from "./curves.js";
import {computeMbsPoses} from "./kinematics.js";
import {MARK_COLORS} from "./marks.js";
import {jointPositions, onPositionsChange, showPositions} from "./positions.js";
import {scene} from "./scene.js";
import {selection} from "./selection.js";

// time (s), isPlaying, and the functions seek(time), play(isOn) and reset().
export const player = {time: 0, isPlaying: false, seek: null, play: null, reset: null};

// The results by frame: see read_motion in motion.py.
const motion = {joints: [], forces: [], times: [], positions: [], loads: [], energies: []};
// The camera sees the whole motion, by so many of its frames.
const FITTED_FRAMES = 60;

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
const computePosesOfFrame = (frame) => computeMbsPoses(
  new Map(motion.joints.map((name, joint) => [name, getPosition(frame, joint)])));

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
  const points = Array.from(motion.times, (_, frame) =>
    vector().setFromMatrixPosition(computePosesOfFrame(frame).bodies.get(body)));
  trail = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
    new THREE.LineBasicMaterial({color: MARK_COLORS.stops}));
  scene.add(trail);
}

// --- curves over time ---

function listCurves() {
  const makeCurve = (name, kind, getValue) =>
    ({name, kind, values: Array.from(motion.times, (_, frame) => getValue(frame))});
  const curves = motion.joints.map((name, joint) =>
    makeCurve(name, jointByName.get(name).joint.type[0], (frame) => getPosition(frame, joint)));
  curves.push(...motion.forces.map(({name}, force) =>
    makeCurve(`|${name}|`, "force", (frame) => getForce(frame, force).length())));
  if (motion.energies.length) {
    curves.push(makeCurve("kinetic", "energy", getKineticEnergy),
      makeCurve("potential", "energy", getPotentialEnergy),
      makeCurve("sum", "energy", (frame) => getKineticEnergy(frame) + getPotentialEnergy(frame)));
  }
  return curves;
}

// --- the player ---

// Show the force (N) that is the largest of the motion as half of the robot.
function findLargestForce() {
  let largest = 1e-9;
  motion.times.forEach((_, frame) => motion.forces.forEach((__, force) => {
    largest = Math.max(largest, getForce(frame, force).length());
  }));
  return largest;
}

// Show all at a time of the motion: makes player.seek.
function makeSeek(first, last) {
  const {joints, forces} = motion, largestForce = findLargestForce();
  const drawArrow = makeForceArrows(forces.map(({isPush}) => isPush));
  // A slider leaves the frame of the motion, and its forces with it.
  onPositionsChange(() => forces.forEach((_, force) =>
    drawArrow(force, null, null, vector(), largestForce)));
  return (time) => {
    player.time = Math.min(Math.max(time, first), last);
    const frame = findFrame(player.time);
    joints.forEach((name, joint) => jointPositions.set(name, getPosition(frame, joint)));
    showPositions();
    followRobot();
    forces.forEach(({body}, force) => {
      const bodyPose = comparison.mbs.bodies.get(body), point = getForcePoint(frame, force);
      drawArrow(force, bodyPose, point, getForce(frame, force), largestForce);
    });
    updateTrail();
    byId("scrub").value = player.time;
    byId("clock").textContent = `${player.time.toFixed(2)} s`;
    drawPlot(player.time, frame);
  };
}

// Let the motion run: makes player.play.
function makePlay(first, last) {
  return (isOn) => {
    player.isPlaying = isOn;
    byId("play").textContent = isOn ? "Pause" : "Play";
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
}

export function makePlayer() {
  unpackMotion();
  const {times} = motion, first = times[0], last = times[times.length - 1];
  const scrub = byId("scrub"), canvas = byId("curves");
  const showPresent = () => player.seek(player.time);
  makePlots(times, listCurves(), () => drawPlot(player.time, findFrame(player.time)));
  const every = Math.ceil(times.length / FITTED_FRAMES);
  fitMotion(Array.from({length: Math.ceil(times.length / every)},
    (_, k) => computePosesOfFrame(k * every)));
  player.seek = makeSeek(first, last);
  player.play = makePlay(first, last);
  player.reset = () => { player.play(false); player.seek(first); };
  byId("play").onclick = () => player.play(!player.isPlaying);
  byId("reset").onclick = player.reset;
  Object.assign(scrub, {min: first, max: last});
  scrub.oninput = () => { player.play(false); player.seek(+scrub.value); };
  canvas.onclick = (event) => player.seek(findPlotTime(event.offsetX));
  byId("trail").onchange = byId("follow").onchange = showPresent;
  onSpace(byId("play"));
  player.seek(first);
}

// The space bar presses a button, but where a button, a field or a row uses the space itself.
export function onSpace(button) {
  document.addEventListener("keydown", (event) => {
    if (event.key !== " " || !["BODY", "CANVAS"].includes(event.target.tagName)) return;
    event.preventDefault();
    button.click();
  });
}
