// The camera: turned, moved and zoomed by OrbitControls of three.js.

import {byId, data, robotSize, vector} from "./basics.js";
import {comparison} from "./comparison.js";
import {onTwoFingers, onZoomingWheel} from "./gestures.js";
import {camera, groups, requestDrawing, scene} from "./scene.js";
import {drawnShapes} from "./shapes.js";
import {bones} from "./skeleton.js";

let controls = null;

// The box around the robot, without a base that is much larger, such as a floor.
export function computeRobotBox() {
  const box = new THREE.Box3(), baseBox = new THREE.Box3();
  scene.updateMatrixWorld(true);
  for (const shape of drawnShapes) {
    if (shape.side === "mbs") (shape.owner === null ? baseBox : box).expandByObject(shape.group);
  }
  const diagonal = (each) => each.getSize(vector()).length();
  if (box.isEmpty() || diagonal(baseBox) < 3 * diagonal(box)) box.union(baseBox);
  if (!drawnShapes.length) bones.forEach(({object}) => box.expandByObject(object));
  for (const [name, group] of [...groups.mbs, ...groups.urdf]) {
    if (name !== null && name !== data.urdf.root) {
      box.expandByPoint(vector().setFromMatrixPosition(group.matrix));
    }
  }
  return box.isEmpty() ? box.expandByPoint(vector()) : box;
}

// --- following ---

// The point of the robot that the camera has followed last (m).
let followedPoint = null;
// How much further from that point a motion reaches than the start does (m).
let extraReach = 0;

// The mean of the origins of all bodies.
const computeMiddle = ({bodies}) => {
  const origins = data.mbs.bodies.map(({name}) => vector().setFromMatrixPosition(bodies.get(name)));
  return origins.reduce((sum, origin) => sum.add(origin), vector())
    .divideScalar(origins.length || 1);
};

// How far a body is from the middle of the robot, at most (m).
function computeReach(poses) {
  const middle = computeMiddle(poses);
  return Math.max(0, ...data.mbs.bodies.map(({name}) =>
    vector().setFromMatrixPosition(poses.bodies.get(name)).distanceTo(middle)));
}

// Let the whole robot be seen in all poses of a motion.
export function fitMotion(posesOfFrames) {
  const reaches = posesOfFrames.map(computeReach);
  extraReach = Math.max(0, ...reaches.map((reach) => reach - reaches[0]));
}

// Move the camera as the robot has moved, if the user wants it.
export function followRobot() {
  const middle = computeMiddle(comparison.mbs);
  if (controls && followedPoint && byId("follow").checked) {
    const shift = middle.clone().sub(followedPoint);
    controls.target.add(shift);
    camera.position.add(shift);
    controls.update();
  }
  followedPoint = middle;
}

// --- moving ---

// Show the whole robot, from the side from which it is seen now.
export function fitCamera() {
  const ball = computeRobotBox().getBoundingSphere(new THREE.Sphere());
  const halfHeight = camera.fov * Math.PI / 360;  // as angles (rad)
  const halfWidth = Math.atan(Math.tan(halfHeight) * camera.aspect);
  const radius = Math.max(ball.radius + extraReach, 0.05 * robotSize);
  followedPoint = computeMiddle(comparison.mbs);
  const distance = 1.18 * radius / Math.sin(Math.min(halfHeight, halfWidth));
  const offset = camera.position.clone().sub(controls.target).setLength(distance);
  // There is a little room around the robot, and more above it, where the buttons are.
  controls.target.copy(ball.center).setZ(ball.center.z + 0.12 * ball.radius);
  camera.position.copy(controls.target).add(offset);
  controls.update();
}

// Adapt the range of depth that is drawn to the distance of the camera.
export function updateDepthRange() {
  const distance = camera.position.distanceTo(controls.target);
  camera.near = distance / 100;
  camera.far = distance + 60 * robotSize;
  camera.updateProjectionMatrix();
  requestDrawing();
}

// Let the mouse, fingers and keys on the canvas move the camera; onClick is called for a click.
export function attachControls(canvas, onClick) {
  // The spherical coordinates of three.js have y up.
  camera.position.setFromSphericalCoords(1, Math.PI / 2 - 0.32, Math.PI / 2 + 0.45)
    .applyAxisAngle(vector(1, 0, 0), Math.PI / 2);
  controls = new THREE.OrbitControls(camera, canvas);
  controls.addEventListener("change", updateDepthRange);
  // Its wheel would stop the page, and two fingers are ours: see gestures.js.
  controls.enableZoom = false;
  controls.touches.TWO = null;
  // One finger that moves up or down scrolls the page.
  canvas.style.touchAction = "pan-y";
  // OrbitControls of this version does not end a touch that the page has taken for scrolling.
  canvas.addEventListener("pointercancel", ({pointerId, pointerType}) =>
    document.dispatchEvent(new PointerEvent("pointerup", {pointerId, pointerType})));
  onZoomingWheel(canvas, (event) =>
    orbit(0, 0, Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.003)));
  onTwoFingers(canvas, ({from, to, factor}) => {
    pan(to[0] - from[0], to[1] - from[1], canvas.clientHeight);
    orbit(0, 0, 1 / factor);
  });
  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => { pressed = event; });
  canvas.addEventListener("click", (event) => {
    const [dx, dy] = [event.clientX - pressed.clientX, event.clientY - pressed.clientY];
    if (Math.hypot(dx, dy) < 4) onClick(event);  // else it was a drag
  });
  canvas.addEventListener("dblclick", fitCamera);
  canvas.addEventListener("keydown", moveByKey);
  Object.assign(canvas, {tabIndex: 0, role: "application"});
  canvas.ariaLabel = "The robot in 3D: arrow keys turn it, + and - zoom, Home shows all of it";
}

// Move the camera by px of the canvas, in the plane of the picture.
function pan(dx, dy, height) {
  const distance = camera.position.distanceTo(controls.target);
  const scale = 2 * distance * Math.tan(camera.fov * Math.PI / 360) / height;  // m per px
  const shift = vector(-dx * scale, dy * scale, 0).applyQuaternion(camera.quaternion);
  controls.target.add(shift);
  camera.position.add(shift);
  controls.update();
}

function moveByKey(event) {
  const turn = {ArrowLeft: 0.1, ArrowRight: -0.1}[event.key] || 0;  // rad
  const tilt = {ArrowUp: -0.1, ArrowDown: 0.1}[event.key] || 0;  // rad
  const zoom = {"+": 0.9, "-": 1.1}[event.key] || 1;
  if (event.key === "Home") fitCamera();
  else if (turn || tilt || zoom !== 1) orbit(turn, tilt, zoom);
  else return;
  event.preventDefault();
}

function orbit(turn, tilt, zoom) {
  const offset = camera.position.clone().sub(controls.target), up = vector(0, 0, 1);
  const polarAngle = offset.angleTo(up);
  const newPolarAngle = Math.min(Math.max(polarAngle + tilt, 0.05), Math.PI - 0.05);
  const tiltAxis = vector().crossVectors(up, offset).normalize();
  offset.applyAxisAngle(tiltAxis, newPolarAngle - polarAngle);
  offset.applyAxisAngle(up, turn).multiplyScalar(zoom);
  camera.position.copy(controls.target).add(offset);
  controls.update();
}
