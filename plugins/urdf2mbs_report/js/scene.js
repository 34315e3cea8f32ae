// The scene: lights, the camera, a group for each body and link, and the grid below them.

import {byId, element, size} from "./basics.js";

export const view = byId("view");
export const scene = new THREE.Scene();
export const camera = new THREE.PerspectiveCamera(38, 1, size / 200, size * 200);
camera.up.set(0, 0, 1);
export let renderer = null;
try {
  // the last picture is kept, so that the page can be printed
  renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
} catch (error) {
  view.append(element("div", "nogl",
    "This browser has no WebGL, so the 3D model cannot be drawn; all else on the page works."));
}
scene.add(new THREE.HemisphereLight(0xffffff, 0x8d96a8, 0.72));
const lamp = new THREE.DirectionalLight(0xffffff, 0.42);
const sun = new THREE.DirectionalLight(0xffffff, 0.22);
sun.position.set(-1, -2, 3);
scene.add(camera, sun);
camera.add(lamp, lamp.target);
lamp.position.set(0.6, 0.8, 1);
lamp.target.position.set(0, 0, -1);

export const sides = {mbs: new THREE.Group(), urdf: new THREE.Group()};
scene.add(sides.mbs, sides.urdf);
// by name, null for the base: what moves with a body or a link
export const holders = {mbs: new Map(), urdf: new Map()};
export function holder(side, name) {
  const found = holders[side].get(name);
  if (found) return found;
  const group = new THREE.Group();
  group.matrixAutoUpdate = false;
  holders[side].set(name, group);
  sides[side].add(group);
  return group;
}

export function place(object, pose) {
  object.matrixAutoUpdate = false;
  object.matrix.copy(pose);
  return object;
}

// what each switch of the page shows and hides
export const kinds = {shapes: [], skeleton: [], frames: [], coms: [], inertias: [], collisions: [],
  sensors: [], contacts: [], forces: [], loops: [], stops: []};
export function keep(kind, parent, object) {
  parent.add(object);
  kinds[kind].push(object);
  return object;
}

let isOld = true;
export const redraw = () => { isOld = true; };
export function drawWhenOld(resized) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2), canvas = renderer.domElement;
  const frame = () => {
    requestAnimationFrame(frame);
    const width = view.clientWidth, height = view.clientHeight;
    const fits = canvas.width === Math.floor(width * ratio) && canvas.height === Math.floor(height * ratio);
    if (width && height && !fits) {
      renderer.setPixelRatio(ratio);
      renderer.setSize(width, height);
      camera.aspect = width / height;
      resized();
    }
    if (!isOld) return;
    isOld = false;
    renderer.render(scene, camera);
  };
  frame();
}

export function picture() {
  renderer.render(scene, camera);
  return renderer.domElement.toDataURL();
}

export const dark = window.matchMedia("(prefers-color-scheme: dark)").matches;
export const grid = new THREE.Group();
scene.add(grid);
export function layGrid(low) {
  const step = 10 ** Math.round(Math.log10(size / 5));
  const cells = 2 * Math.ceil(1.6 * size / step);
  const lines = new THREE.GridHelper(cells * step, cells, ...(dark ? [0x4a5564, 0x2b333e]
    : [0xaab4c2, 0xd3dae3]));
  lines.rotation.x = Math.PI / 2;
  lines.position.z = low - 1e-3 * size;
  grid.add(lines);
}
