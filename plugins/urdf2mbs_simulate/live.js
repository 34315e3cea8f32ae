// The interactive robot: the C of its simulation, as WebAssembly.  It can be pulled, dropped, and held by
// its controller.

import {makeForceArrows} from "./arrows.js";
import {bodyByName, byId, createElement, data, decodeBase64, decompress, jointNumbers, robotSize, vector}
  from "./basics.js";
import {followRobot} from "./camera.js";
import {comparison} from "./comparison.js";
import {player} from "./player.js";
import {jointPositions, onPositionsChange, showPositions} from "./positions.js";
import {makeRoving} from "./roving.js";
import {camera, renderer, view} from "./scene.js";
import {castRay, findBodyAt, select} from "./selection.js";

// data.live is made by live.py: code (WebAssembly, gzipped) and numbers (float64), in base64; places: where
// rows begin in the numbers; forces: the bodies of the external forces; states: how many user states;
// floats: true if the base may turn by any angle
const {live} = data;

const GRAVITY = 9.81;  // m/s^2
const MAX_FRAME_TIME = 100;  // ms of real time that one frame simulates at most
const COMPUTING_TIME = 30;  // ms of computing in one frame
const STEPS_PER_CALL = 10;
const WASI_ENOSYS = 52;  // the error of a function of the system that does not exist
const FORCE_ROW = 10, FORCE_POINT = 7;  // of SWr: index 0, force, torque, point; a length comes before each

const weight = GRAVITY * data.mbs.bodies.reduce((sum, body) => sum + (body.mass || 0), 0);

let robot;  // the functions of live.c, and its memory
let simulation;  // the address of the Page of live.c
let numbersAddress;
let printed = "";  // the output of the user's C
let time = 0;  // s
let isRunning = false;
let grabbed = null;  // {body, point (m, in axes of the body), target (m, in those of the base)}
let drawArrow;

// --- the memory of the simulation ---

// Return a row of the numbers, from its index 0, without copying it.
function getRow(name, count, offset = 0) {
  const address = numbersAddress + 8 * (live.places[name] + offset);
  return new Float64Array(robot.memory.buffer, address, count);
}

const getJointRow = (name) => getRow(name, jointNumbers.size + 1);
const getStateRow = () => getRow("ux", live.states + 1);

// --- loading ---

// Keep the output of the user's C: the WASI function that writes the buffers of a list.
function writeFile(file, buffers, count, writtenAddress) {
  const memory = new DataView(robot.memory.buffer);
  let total = 0;
  for (let k = 0; k < count; k++) {
    const address = memory.getUint32(buffers + 8 * k, true);
    const length = memory.getUint32(buffers + 8 * k + 4, true);
    printed += new TextDecoder().decode(new Uint8Array(robot.memory.buffer, address, length));
    total += length;
  }
  memory.setUint32(writtenAddress, total, true);
  return 0;
}

// Load the simulation; return false if it cannot start.
async function load() {
  const system = new Proxy({fd_write: writeFile},
    {get: (functions, name) => functions[name] || (() => WASI_ENOSYS)});
  const module = await WebAssembly.instantiate(await decompress(live.code),
    {wasi_snapshot_preview1: system});
  robot = module.instance.exports;
  robot._initialize();
  const packed = new Float64Array(decodeBase64(live.numbers).buffer);
  numbersAddress = robot.room(packed.length);
  new Float64Array(robot.memory.buffer, numbersAddress).set(packed);
  simulation = robot.begin(numbersAddress);
  return simulation !== 0;
}

// --- running ---

function showMessage(text) {
  byId("live-message").textContent = [text, printed.trim()].filter(Boolean).join("; ");
}

const showTime = () => { byId("clock").textContent = `${time.toFixed(2)} s`; };

// Start or stop the simulation, which follows real time, times the speed of the player, if it can.
function setRunning(shouldRun) {
  isRunning = shouldRun;
  byId("live").textContent = shouldRun ? "Stop" : "Live";
  // A finger pulls the robot that runs, and scrolls the page otherwise.
  if (renderer) renderer.domElement.style.touchAction = shouldRun ? "none" : "pan-y";
  if (!shouldRun) return;
  player.play(false);
  let last = performance.now();
  requestAnimationFrame(function runFrame(present) {
    if (player.isPlaying) setRunning(false);
    if (!isRunning) return;
    const elapsed = Math.min(Math.max(present - last, 0), MAX_FRAME_TIME) / 1000;
    const target = time + elapsed * byId("speed").value;
    last = present;
    if (advance(target, COMPUTING_TIME)) {
      showMessage(time < target - 1e-9 ? "slower than asked for" : "");
      requestAnimationFrame(runFrame);
    }
  });
}

// Simulate until a time (s), but compute for some ms at most; return false if the run has ended.
function advance(target, duration) {
  const end = performance.now() + duration;
  applyPull();
  while (time < target && performance.now() < end) {
    const reached = robot.go(simulation, target, STEPS_PER_CALL);
    if (reached < 0) {
      setRunning(false);
      showMessage(reached < -1 ? `user code has ended the run after ${time.toFixed(3)} s`
        : `after ${time.toFixed(3)} s no step is short enough: a force has diverged, or a loop cannot close; `
          + "press Reset");
      return false;
    }
    time = reached;
  }
  draw();
  return true;
}

function draw() {
  const positions = getJointRow("q");
  for (const [name, number] of jointNumbers) jointPositions.set(name, positions[number]);
  showPositions();
  followRobot();
  showTime();
  live.forces.forEach((body, k) => {
    const force = getRow("SWr", FORCE_ROW, (FORCE_ROW + 1) * (k + 1));
    const point = vector().fromArray(force, FORCE_POINT);
    drawArrow(k, comparison.mbs.bodies.get(body), point, vector().fromArray(force, 1), weight);
  });
  if (grabbed) {
    const pose = comparison.mbs.bodies.get(grabbed.body);
    drawArrow(live.forces.length, pose, grabbed.point, computePull(grabbed), weight);
  }
}

// --- the mouse ---

// Return the force of a pull (N): over the size of the robot, it is the robot's weight.
function computePull({body, point, target}) {
  const position = point.clone().applyMatrix4(comparison.mbs.bodies.get(body));
  return target.clone().sub(position).multiplyScalar(weight / robotSize);
}

function applyPull() {
  if (!grabbed) {
    robot.pull_at(simulation, 0, 0, 0, 0, 0, 0, 0);
    return;
  }
  const lastJoint = jointNumbers.get(bodyByName.get(grabbed.body).joints.at(-1).name);
  robot.pull_at(simulation, lastJoint, ...grabbed.point.toArray(), ...computePull(grabbed).toArray());
}

// Begin to pull the body below the mouse, in the plane through its point that faces the camera.
function grab(event) {
  const isPulling = isRunning && event.button === 0 && event.target === renderer.domElement;
  const hit = isPulling && findBodyAt(event);
  if (!hit || !bodyByName.has(hit.body)) return;
  event.stopPropagation();  // the view does not turn
  select(hit.body);
  const normal = camera.getWorldDirection(vector());
  const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, hit.point);
  const toBody = comparison.mbs.bodies.get(hit.body).clone().invert();
  grabbed = {body: hit.body, point: hit.point.clone().applyMatrix4(toBody), target: hit.point};
  const move = (moved) => castRay(moved).ray.intersectPlane(plane, grabbed.target);
  const release = () => {
    grabbed = null;
    window.removeEventListener("pointermove", move);
    const ignore = (click) => click.stopPropagation();  // it would choose a body
    window.addEventListener("click", ignore, {capture: true, once: true});
  };
  window.addEventListener("pointermove", move);
  window.addEventListener("pointerup", release, {once: true});
}

// --- the buttons ---

function addButton(bar, text, title, onclick) {
  const button = createElement("button", "", text);
  Object.assign(button, {title, onclick});
  bar.append(button);
  return button;
}

// Return a function that starts at time 0 from the first state, after a change of its positions.
function makeRestart() {
  const start = {q: [...getJointRow("q")], qd: [...getJointRow("qd")]};
  const states = getStateRow().slice();
  return (changePositions) => {
    for (const name of ["q", "qd"]) getJointRow(name).set(start[name]);
    getStateRow().set(states);
    changePositions(getJointRow("q"));
    [time, printed] = [0, ""];
    if (robot.restart(simulation)) {
      showMessage("the robot cannot start here");
    } else {
      showMessage("");
      draw();
    }
  };
}

// Add buttons that drop a floating base: q 1 to 3 are its position, 4 to 6 its angles.
function addDropButtons(bar, restart) {
  const addDrop = (text, turn) => addButton(bar, text, "From one metre higher", () => {
    restart((positions) => {
      positions[3] += 1;
      turn(positions);
    });
    setRunning(true);
  });
  addDrop("Drop", () => {});
  addDrop("Drop on its back", (positions) => { positions[5] = -Math.PI / 2; });
  addDrop("Drop on its side", (positions) => { positions[4] = Math.PI / 2; });
}

// Add the box that switches the controller of the user model 'hold'.
function addHoldBox(bar) {
  const label = createElement("label", "", "Hold");
  const box = createElement("input");
  label.title = "The controller that holds the start position";
  Object.assign(box, {type: "checkbox", checked: getRow("hold", 1)[0] !== 0});
  box.onchange = () => { getRow("hold", 1)[0] = Number(box.checked); };
  label.prepend(box);
  bar.append(label);
}

async function makeLive() {
  if (!await load()) {
    byId("player").after(createElement("p", "note", "The robot cannot start."));
    return;
  }
  const bar = createElement("div", "bar");
  const restart = makeRestart();
  drawArrow = makeForceArrows([...live.forces.map(() => false), true]);
  onPositionsChange(() => [...live.forces, null].forEach((_, k) => drawArrow(k, null, null, vector(), 1)));
  const runTitle = "Run live; then drag a part with the mouse";
  const runButton = addButton(byId("player-buttons"), "Live", runTitle, () => setRunning(!isRunning));
  Object.assign(runButton, {id: "live", tabIndex: -1});
  // Reset goes back to the start, of the motion and of what is simulated here.
  byId("reset").onclick = () => {
    setRunning(false);
    player.reset();
    restart(() => {});
  };
  if (live.floats) addDropButtons(bar, restart);
  if ("hold" in live.places) addHoldBox(bar);
  const message = createElement("output", "");
  message.id = "live-message";
  bar.append(message);
  byId("player").querySelector(".bar").after(bar);
  makeRoving(bar, "button, input");
  showMessage("press Live, then drag a part");
  if (renderer) view.addEventListener("pointerdown", grab, {capture: true});
  const functions = {restart, setRunning, advance, getJointRow, getTime: () => time};
  Object.assign(window.urdf2mbs, {live: functions});
}

window.urdf2mbs.opened = window.urdf2mbs.opened.then(makeLive);
