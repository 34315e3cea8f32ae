// The motion of a simulated project: play, the trail of a body, arrows of forces, and curves.

import {bodyOf, byId, data, vector} from "./basics.js";
import {chosen} from "./choose.js";
import {now} from "./compare.js";
import {mbsPoses} from "./kinematics.js";
import {MARK, makeArrows} from "./marks.js";
import {q, settle} from "./positions.js";
import {scene} from "./scene.js";

export const player = {time: 0, playing: false, at: null, play: null};
let joints, forces, times, positions, loads, energies;

function unpackMotion() {
  const floats = (text) => new Float32Array(
    Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
  ({joints, forces} = data.motion);
  [times, positions, loads, energies] = ["time", "q", "F", "E"].map((name) => floats(data.motion[name]));
}

// the frame at or before a time
const frameAt = (time) => Math.max(0, times.findLastIndex((one) => one <= time + 1e-6));
const coordinate = (frame, j) => positions[frame * joints.length + j];
// of a force in a frame: the force (N), or with 3 the point where it acts (m)
const load = (k, frame, part = 0) => vector().fromArray(loads, 6 * (frame * forces.length + k) + part);

// the way of the body that is chosen
let trail = null, trailOf;
function drawTrail() {
  const body = byId("trail").checked && bodyOf.has(chosen.body) ? chosen.body : undefined;
  if (body === trailOf) return;
  trailOf = body;
  if (trail) scene.remove(trail);
  trail = null;
  if (body === undefined) return;
  const points = Array.from(times, (_, i) => vector().setFromMatrixPosition(
    mbsPoses(new Map(joints.map((name, j) => [name, coordinate(i, j)]))).bodies.get(body)));
  trail = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
    new THREE.LineBasicMaterial({color: MARK.stops}));
  scene.add(trail);
}

// what can be drawn over time: a name, and lines, each with a name and its value in a frame
let curves = [];
function makeCurves() {
  const [kinetic, potential] = [(frame) => energies[2 * frame], (frame) => energies[2 * frame + 1]];
  const ofJoints = joints.map((name, j) => [name, (frame) => coordinate(frame, j)]);
  const ofForces = forces.map(([, name], k) => [`|${name}| (N)`, (frame) => load(k, frame).length()]);
  const ofEnergy = energies.length ? [["kinetic (J)", kinetic], ["potential (J)", potential],
    ["sum (J)", (frame) => kinetic(frame) + potential(frame)]] : [];
  curves = [["Joints", ofJoints], ["Forces", ofForces], ["Energy", ofEnergy]]
    .filter(([, lines]) => lines.length);
  curves.push(...[...ofJoints, ...ofForces].map((line) => [line[0], [line]]));
  curves.forEach(([name], k) => byId("curve").add(new Option(name, k)));
}

function drawCurves() {
  const canvas = byId("curves"), pen = canvas.getContext("2d");
  const width = canvas.width = canvas.clientWidth || 600, height = canvas.height;
  const lines = curves[byId("curve").value][1].map(([name, value]) =>
    [name, Array.from(times, (_, i) => value(i))]);
  const all = lines.flatMap(([, values]) => values);
  const low = all.reduce((a, b) => Math.min(a, b)), high = all.reduce((a, b) => Math.max(a, b));
  const x = (time) => (time - times[0]) / (times[times.length - 1] - times[0] || 1) * width;
  const y = (value) => height - 8 - (value - low) / (high - low || 1) * (height - 16);
  const frame = frameAt(player.time);
  lines.forEach(([name, values], n) => {
    pen.strokeStyle = pen.fillStyle = `hsl(${n * 137.5 % 360} 60% 48%)`;
    pen.beginPath();
    values.forEach((value, i) => pen.lineTo(x(times[i]), y(value)));
    pen.stroke();
    if (lines.length < 9) pen.fillText(`${name}: ${+values[frame].toPrecision(4)}`, 60, 12 + 12 * n);
  });
  pen.fillStyle = pen.strokeStyle = getComputedStyle(canvas).color;
  pen.fillText(`${+high.toPrecision(4)}`, 4, 12);
  pen.fillText(`${+low.toPrecision(4)}`, 4, height - 4);
  pen.strokeRect(x(player.time), 0, 0.5, height);
}

export function makePlayer() {
  unpackMotion();
  makeCurves();
  const first = times[0], last = times[times.length - 1];
  const scrub = byId("scrub"), button = byId("play"), canvas = byId("curves");
  const drawArrow = makeArrows(forces.map(([, , pushed]) => pushed));
  let most = 1e-9;
  times.forEach((_, i) => forces.forEach((__, k) => { most = Math.max(most, load(k, i).length()); }));

  player.at = (time) => {
    player.time = Math.min(Math.max(time, first), last);
    const frame = frameAt(player.time);
    joints.forEach((name, j) => q.set(name, coordinate(frame, j)));
    settle();
    forces.forEach(([body], k) => {
      drawArrow(k, now.mbs.bodies.get(body), load(k, frame, 3), load(k, frame), most);
    });
    drawTrail();
    scrub.value = player.time;
    byId("clock").textContent = `${player.time.toFixed(2)} s`;
    drawCurves();
  };
  player.play = (on) => {
    player.playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (player.time >= last) player.at(first);
    let before = performance.now();
    const step = (time) => {
      if (!player.playing) return;
      let next = player.time + Math.max(time - before, 0) / 1000 * byId("speed").value;
      before = time;
      if (next >= last && byId("repeat").checked) next = first;
      player.at(next);
      if (player.time >= last && !byId("repeat").checked) player.play(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  };
  button.onclick = () => player.play(!player.playing);
  Object.assign(scrub, {min: first, max: last});
  scrub.oninput = () => { player.play(false); player.at(+scrub.value); };
  canvas.onclick = (event) => player.at(first + event.offsetX / canvas.clientWidth * (last - first));
  byId("curve").onchange = byId("trail").onchange = () => player.at(player.time);
  document.addEventListener("keydown", (event) => {
    // a button, a field or a row takes the space itself
    if (event.key !== " " || event.target !== document.body) return;
    event.preventDefault();
    button.click();
  });
  byId("player").hidden = false;
  player.at(first);
}
