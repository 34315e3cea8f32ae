// The live robot: the C of its simulation, as WebAssembly.  It is pulled, dropped, and held or not.

import {makeForceArrows} from "./arrows.js";
import {bodyByName, byId, createElement, data, decodeBase64, decompress, jointNumbers, robotSize, vector}
  from "./basics.js";
import {comparison} from "./comparison.js";
import {player} from "./player.js";
import {jointPositions, onPositionsChange, updatePositions} from "./positions.js";
import {camera, renderer, view} from "./scene.js";
import {castRay, findBodyAt, select} from "./selection.js";

// data.live, of live.py: code (WebAssembly, gzipped) and numbers (float64) in base64; places: where rows begin
// in the numbers; forces: the bodies of the external forces; floats: the base may turn any way
const {live} = data;
const weight = 9.81 * data.mbs.bodies.reduce((sum, body) => sum + (body.mass || 0), 0);
let robot, page, at, printed = "", time = 0, running = false, grabbed = null, drawArrow;

const row = (name, count, skip = 0) =>
  new Float64Array(robot.memory.buffer, at + 8 * (live.places[name] + skip), count);
const joints = (name) => row(name, jointNumbers.size + 1);

// what the user's C prints is shown
const system = {fd_write(file, parts, count, written) {
  const words = new DataView(robot.memory.buffer);
  let length = 0;
  for (let k = 0; k < count; k++) {
    const part = [words.getUint32(parts + 8 * k, true), words.getUint32(parts + 8 * k + 4, true)];
    printed += new TextDecoder().decode(new Uint8Array(robot.memory.buffer, ...part));
    length += part[1];
  }
  words.setUint32(written, length, true);
  return 0;
}};
const missing = 52;  // what WASI answers of a function that there is not

async function load() {
  const found = new Proxy(system, {get: (_, name) => system[name] || (() => missing)});
  const made = await WebAssembly.instantiate(await decompress(live.code),
    {wasi_snapshot_preview1: found});
  robot = made.instance.exports;
  robot._initialize();
  const packed = new Float64Array(decodeBase64(live.numbers).buffer);
  at = robot.room(packed.length);
  new Float64Array(robot.memory.buffer, at).set(packed);
  page = robot.begin(at);
  return !page;
}

function tell(text) {
  byId("live-said").textContent = [text, printed.trim()].filter(Boolean).join("; ");
}

function run(on) {
  running = on;
  byId("live").textContent = on ? "Stop" : "Live";
  if (!on) return;
  player.play(false);
  let before = performance.now();
  requestAnimationFrame(function frame(when) {
    if (player.isPlaying) run(false);
    if (!running) return;
    const passed = Math.min(Math.max(when - before, 0), 100) / 1000, wanted = time + passed * byId("speed").value;
    before = when;
    if (pass(wanted, 30)) {
      tell(`${time.toFixed(2)} s${time < wanted - 1e-9 ? ", slower than asked for" : ""}`);
      requestAnimationFrame(frame);
    }
  });
}

// let time pass until a moment, or for so many ms; true if the robot can go on
function pass(wanted, most) {
  const end = performance.now() + most;
  pullOn();
  while (time < wanted && performance.now() < end) {
    const reached = robot.go(page, wanted, 10);
    if (reached < 0) {
      run(false);
      tell(reached < -1 ? `user code has ended the run after ${time.toFixed(3)} s`
        : `after ${time.toFixed(3)} s no step is short enough: a force has diverged, or a loop cannot close; `
          + "Reset begins again");
      return false;
    }
    time = reached;
  }
  draw();
  return true;
}

function draw() {
  const here = joints("q");
  for (const [name, number] of jointNumbers) jointPositions.set(name, here[number]);
  updatePositions();
  live.forces.forEach((body, k) => {
    const force = row("SWr", 10, 11 * (k + 1));
    drawArrow(k, comparison.mbs.bodies.get(body), vector().fromArray(force, 7), vector().fromArray(force, 1), weight);
  });
  if (grabbed) drawArrow(live.forces.length, comparison.mbs.bodies.get(grabbed.body), grabbed.at, pullOf(grabbed), weight);
}

// --- by hand ---

// a pull by the size of the robot is its weight
function pullOf({body, at: point, to}) {
  return to.clone().sub(point.clone().applyMatrix4(comparison.mbs.bodies.get(body))).multiplyScalar(weight / robotSize);
}

function pullOn() {
  if (!grabbed) return robot.pull_at(page, 0, 0, 0, 0, 0, 0, 0);
  const joint = jointNumbers.get(bodyByName.get(grabbed.body).joints.at(-1).name);
  robot.pull_at(page, joint, ...grabbed.at.toArray(), ...pullOf(grabbed).toArray());
}

function grab(event) {
  const hit = running && event.button === 0 && event.target === renderer.domElement && findBodyAt(event);
  if (!hit || !bodyByName.has(hit.body)) return;
  event.stopPropagation();  // the view does not turn
  select(hit.body);
  const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(vector()), hit.point);
  grabbed = {body: hit.body, to: hit.point,
    at: hit.point.clone().applyMatrix4(comparison.mbs.bodies.get(hit.body).clone().invert())};
  const move = (moved) => castRay(moved).ray.intersectPlane(plane, grabbed.to);
  window.addEventListener("pointermove", move);
  window.addEventListener("pointerup", () => {
    grabbed = null;
    window.removeEventListener("pointermove", move);
    window.addEventListener("click", (click) => click.stopPropagation(), {capture: true, once: true});
  }, {once: true});
}

async function makeLive() {
  if (await load()) return byId("player").after(createElement("p", "note", "The robot cannot start."));
  const bar = createElement("div", "bar"), start = ["q", "qd"].map((name) => [...joints(name)]);
  const states = row("ux", live.states + 1).slice();
  const begin = (change) => {
    ["q", "qd"].forEach((name, k) => joints(name).set(start[k]));
    row("ux", live.states + 1).set(states);
    change(joints("q"));
    [time, printed] = [0, ""];
    if (robot.restart(page)) tell("the robot cannot start here");
    else {
      tell("0.00 s");
      draw();
    }
  };
  const button = (text, title, act) => {
    const made = createElement("button", "", text);
    Object.assign(made, {title, onclick: act});
    bar.append(made);
    return made;
  };
  drawArrow = makeForceArrows([...live.forces.map(() => false), true]);
  const hide = () => [...live.forces, null].forEach((_, k) => drawArrow(k, null, null, vector(), 1));
  onPositionsChange(hide);
  button("Live", "Run live; then drag a part with the mouse", () => run(!running)).id = "live";
  button("Reset", "Back to the start", () => begin(() => {}));
  const drop = (text, turn) => live.floats && button(text, "From one metre higher", () => {
    begin((row) => { row[3] += 1; turn(row); });
    run(true);
  });
  drop("Drop", () => {});
  drop("Drop on its back", (row) => { row[5] = -Math.PI / 2; });
  drop("Drop on its side", (row) => { row[4] = Math.PI / 2; });
  if ("hold" in live.places) {
    const label = createElement("label", "", "Hold"), box = createElement("input");
    label.title = "The controller that holds the start position";
    Object.assign(box, {type: "checkbox", checked: row("hold", 1)[0] !== 0});
    box.onchange = () => { row("hold", 1)[0] = +box.checked; };
    label.prepend(box);
    bar.append(label);
  }
  const said = createElement("output", "");
  said.id = "live-said";
  bar.append(said);
  byId("player").before(bar);
  tell("press Live, then drag a part");
  if (renderer) view.addEventListener("pointerdown", grab, {capture: true});
  Object.assign(window.urdf2mbs, {live: {begin, run, pass, joints, time: () => time}});
}
window.urdf2mbs.ready = window.urdf2mbs.ready.then(makeLive);
