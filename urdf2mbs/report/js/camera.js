// The camera: turn, move, zoom.

import {data, size, vector} from "./basics.js";
import {camera, holders, redraw, scene, view} from "./scene.js";
import {drawn} from "./shapes.js";

const eye = {target: vector(), distance: 3 * size, around: 0.45, above: 0.32};

export function aim() {
  const flat = Math.cos(eye.above);
  camera.position.set(Math.cos(eye.around) * flat, Math.sin(eye.around) * flat, Math.sin(eye.above))
    .multiplyScalar(eye.distance).add(eye.target);
  camera.near = eye.distance / 100;
  camera.far = eye.distance + 60 * size;
  camera.lookAt(eye.target);
  camera.updateProjectionMatrix();
  redraw();
}

// the box around the robot, without its base
export function extent() {
  const box = new THREE.Box3();
  scene.updateMatrixWorld(true);
  for (const one of drawn) {
    if (one.side === "mbs" && one.owner !== null) box.expandByObject(one.group);
  }
  for (const [name, group] of [...holders.mbs, ...holders.urdf]) {
    if (name !== null && name !== data.urdf.root) {
      box.expandByPoint(vector().setFromMatrixPosition(group.matrix));
    }
  }
  return box.isEmpty() ? box.expandByPoint(vector()) : box;
}

export function fit() {
  const ball = extent().getBoundingSphere(new THREE.Sphere());
  // a little room around it, and more above, where the buttons are
  eye.target.copy(ball.center).setZ(ball.center.z + 0.12 * ball.radius);
  const half = camera.fov * Math.PI / 360, wide = Math.atan(Math.tan(half) * camera.aspect);
  eye.distance = 1.18 * Math.max(ball.radius, 0.05 * size) / Math.sin(Math.min(half, wide));
  aim();
}

function orbit(dx, dy) {
  eye.around -= dx * 0.008;
  eye.above = Math.min(Math.max(eye.above + dy * 0.008, -1.57), 1.57);
}

function pan(dx, dy) {
  const scale = 2 * eye.distance * Math.tan(camera.fov * Math.PI / 360) / view.clientHeight;
  const column = (k) => vector().setFromMatrixColumn(camera.matrix, k);
  eye.target.addScaledVector(column(0), -dx * scale).addScaledVector(column(1), dy * scale);
}

// a mouse or fingers on the canvas; ``pick`` is called for a click
export function steer(canvas, pick) {
  const fingers = new Map();
  let moved = 0;
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    moved = 0;
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
    moved += Math.abs(dx) + Math.abs(dy);
    if (fingers.size === 2) {
      const other = [...fingers.values()].find((finger) => finger.pointerId !== event.pointerId);
      const span = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY);
      eye.distance *= span(before) / Math.max(span(event), 1);
      pan(dx / 2, dy / 2);
    } else {
      (event.buttons & 6 || event.shiftKey ? pan : orbit)(dx, dy);
    }
    fingers.set(event.pointerId, event);
    aim();
  });
  for (const kind of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(kind, (event) => {
      fingers.delete(event.pointerId);
      if (kind === "pointerup" && moved < 4 && event.button === 0) pick(event);
    });
  }
  canvas.addEventListener("dblclick", fit);
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    eye.distance *= Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.002);
    aim();
  }, {passive: false});
}
