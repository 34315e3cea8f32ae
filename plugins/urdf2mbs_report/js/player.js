// The motion of a simulated project: play, the trail of a body, arrows of forces, and curves.

import {bodyOf, byId, bytesOf, data, vector} from "./basics.js";
import {chosen} from "./choose.js";
import {now} from "./compare.js";
import {mbsPoses} from "./kinematics.js";
import {MARK, makeArrows} from "./marks.js";
import {onChange, q, settle} from "./positions.js";
import {scene} from "./scene.js";

export const player = {time: 0, playing: false, at: null, play: null};
let joints, forces, times, positions, loads, energies;

function unpackMotion() {
  const floats = (text) => new Float32Array(bytesOf(text).buffer);
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

// what can be drawn over time: a name, and the curves below each other
let plots = [];
function makePlots() {
  const curve = (name, value) => {
    const values = Array.from(times, (_, i) => value(i));
    const [low, high] = [Math.min, Math.max].map((choose) => values.reduce((a, b) => choose(a, b)));
    return {name, values, low, high, moves: high - low};
  };
  const [kinetic, potential] = [(frame) => energies[2 * frame], (frame) => energies[2 * frame + 1]];
  const ofJoints = joints.map((name, j) => curve(name, (frame) => coordinate(frame, j)));
  const ofForces = forces.map(([, name], k) => curve(`|${name}| (N)`, (frame) => load(k, frame).length()));
  const ofEnergy = energies.length ? [curve("kinetic (J)", kinetic), curve("potential (J)", potential),
    curve("sum (J)", (frame) => kinetic(frame) + potential(frame))] : [];
  const most = (all) => all.filter((one) => one.moves > 1e-6).sort((a, b) => b.moves - a.moves).slice(0, 8);
  plots = [["Joints", most(ofJoints)], ["Forces", most(ofForces)], ["Energy", ofEnergy]]
    .filter(([, shown]) => shown.length);
  plots.push(...[...ofJoints, ...ofForces].map((one) => [one.name, [one]]));
  plots.forEach(([name], k) => byId("curve").add(new Option(name, k)));
}

function drawPlots() {
  const canvas = byId("curves"), pen = canvas.getContext("2d"), [, shown] = plots[byId("curve").value];
  const width = canvas.width = canvas.clientWidth || 600, row = shown.length > 1 ? 48 : 150;
  canvas.style.height = `${canvas.height = row * shown.length}px`;
  const ink = getComputedStyle(canvas).color, frame = frameAt(player.time);
  const x = (time) => (time - times[0]) / (times[times.length - 1] - times[0] || 1) * width;
  shown.forEach(({name, values, low, high}, n) => {
    const bottom = row * (n + 1) - 5, y = (value) => bottom - (value - low) / (high - low || 1) * (row - 22);
    pen.strokeStyle = `hsl(${n * 137.5 % 360} 60% 48%)`;
    pen.beginPath();
    values.forEach((value, i) => pen.lineTo(x(times[i]), y(value)));
    pen.stroke();
    pen.fillStyle = ink;
    pen.textAlign = "left";
    pen.fillText(`${name}: ${+values[frame].toPrecision(4)}`, 4, row * n + 11);
    pen.textAlign = "right";
    pen.fillText(`${+low.toPrecision(4)} ... ${+high.toPrecision(4)}`, width - 4, row * n + 11);
  });
  pen.strokeStyle = ink;
  pen.strokeRect(x(player.time), 0, 0.5, canvas.height);
}

export function makePlayer() {
  unpackMotion();
  makePlots();
  const first = times[0], last = times[times.length - 1];
  const scrub = byId("scrub"), button = byId("play"), canvas = byId("curves");
  const drawArrow = makeArrows(forces.map(([, , pushed]) => pushed));
  let most = 1e-9;
  times.forEach((_, i) => forces.forEach((__, k) => { most = Math.max(most, load(k, i).length()); }));

  // a slider leaves the moment, and its forces with it
  onChange(() => forces.forEach((_, k) => drawArrow(k, null, null, vector(), most)));
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
    drawPlots();
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
    if (event.key !== " " || !["BODY", "CANVAS"].includes(event.target.tagName)) return;
    event.preventDefault();
    button.click();
  });
  byId("player").hidden = false;
  player.at(first);
}
