// The camera: turned, moved and zoomed by three's OrbitControls.

import {data, size, vector} from "./basics.js";
import {bones} from "./marks.js";
import {camera, holders, redraw, scene} from "./scene.js";
import {drawn} from "./shapes.js";

// the box around the robot, without a base that is much larger, such as a floor
export function extent() {
  const box = new THREE.Box3(), base = new THREE.Box3(), across = (of) => of.getSize(vector()).length();
  scene.updateMatrixWorld(true);
  for (const one of drawn) {
    if (one.side === "mbs") (one.owner === null ? base : box).expandByObject(one.group);
  }
  if (box.isEmpty() || across(base) < 3 * across(box)) box.union(base);
  if (!drawn.length) bones.forEach(([, object]) => box.expandByObject(object));
  for (const [name, group] of [...holders.mbs, ...holders.urdf]) {
    if (name !== null && name !== data.urdf.root) {
      box.expandByPoint(vector().setFromMatrixPosition(group.matrix));
    }
  }
  return box.isEmpty() ? box.expandByPoint(vector()) : box;
}

let controls = null;

// the whole robot is seen, from the side from which it is seen now
export function fit() {
  const ball = extent().getBoundingSphere(new THREE.Sphere());
  const half = camera.fov * Math.PI / 360, wide = Math.atan(Math.tan(half) * camera.aspect);
  const away = 1.18 * Math.max(ball.radius, 0.05 * size) / Math.sin(Math.min(half, wide));
  const offset = camera.position.clone().sub(controls.target).setLength(away);
  // a little room around it, and more above, where the buttons are
  controls.target.copy(ball.center).setZ(ball.center.z + 0.12 * ball.radius);
  camera.position.copy(controls.target).add(offset);
  controls.update();
}

export function aim() {
  const away = camera.position.distanceTo(controls.target);
  camera.near = away / 100;
  camera.far = away + 60 * size;
  camera.updateProjectionMatrix();
  redraw();
}

function turnByKey(event) {
  const offset = camera.position.clone().sub(controls.target), up = vector(0, 0, 1);
  const turn = {ArrowLeft: 0.1, ArrowRight: -0.1}[event.key] || 0;
  const tilt = {ArrowUp: -0.1, ArrowDown: 0.1}[event.key] || 0;
  const zoom = {"+": 0.9, "-": 1.1}[event.key] || 1;
  if (event.key === "Home") fit();
  else if (turn || tilt || zoom !== 1) {
    const high = offset.angleTo(up), next = Math.min(Math.max(high + tilt, 0.05), Math.PI - 0.05);
    offset.applyAxisAngle(vector().crossVectors(up, offset).normalize(), next - high);
    camera.position.copy(controls.target).add(offset.applyAxisAngle(up, turn).multiplyScalar(zoom));
    controls.update();
  } else return;
  event.preventDefault();
}

// follow the mouse or fingers on the canvas; ``pick`` is called for a click
export function steer(canvas, pick) {
  camera.position.setFromSphericalCoords(1, Math.PI / 2 - 0.32, Math.PI / 2 + 0.45)
    .applyAxisAngle(vector(1, 0, 0), Math.PI / 2);  // three's spherical coordinates have y up
  controls = new THREE.OrbitControls(camera, canvas);
  controls.zoomSpeed = 2;
  controls.addEventListener("change", aim);
  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => { pressed = event; });
  canvas.addEventListener("click", (event) => {
    if (Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) < 4) pick(event);
  });
  canvas.addEventListener("dblclick", fit);
  canvas.addEventListener("keydown", turnByKey);
  Object.assign(canvas, {tabIndex: 0, role: "application"});
  canvas.ariaLabel = "The robot in 3D: arrow keys turn it, + and - zoom, Home shows all of it";
}
