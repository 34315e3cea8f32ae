// The scene: lights, the camera, a group for each body and link, and the grid below them.

import {byId, createElement, robotSize} from "./basics.js";

export const view = byId("view");
export const isDark = window.matchMedia("(prefers-color-scheme: dark)").matches;
export const scene = new THREE.Scene();
export const camera = new THREE.PerspectiveCamera(38, 1, robotSize / 200, robotSize * 200);
camera.up.set(0, 0, 1);
// null without WebGL
export let renderer = null;
try {
  // The last picture is kept, so that the page can be printed.
  renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
} catch (error) {
  view.append(createElement("div", "nogl",
    "This browser has no WebGL, so the 3D model cannot be drawn; all else on the page works."));
}

const headlight = new THREE.DirectionalLight(0xffffff, 0.42);
headlight.position.set(0.6, 0.8, 1);
headlight.target.position.set(0, 0, -1);
camera.add(headlight, headlight.target);
const sun = new THREE.DirectionalLight(0xffffff, 0.22);
sun.position.set(-1, -2, 3);
scene.add(new THREE.HemisphereLight(0xffffff, 0x8d96a8, 0.72), camera, sun);

// --- groups ---

export const sideGroups = {mbs: new THREE.Group(), urdf: new THREE.Group()};
scene.add(sideGroups.mbs, sideGroups.urdf);
// The group that moves with each body ("mbs") or link ("urdf"), by name; null is the base.
export const groups = {mbs: new Map(), urdf: new Map()};

export function getGroup(side, name) {
  if (!groups[side].has(name)) {
    const group = new THREE.Group();
    group.matrixAutoUpdate = false;
    groups[side].set(name, group);
    sideGroups[side].add(group);
  }
  return groups[side].get(name);
}

export function setPose(object, pose) {
  object.matrixAutoUpdate = false;
  object.matrix.copy(pose);
  return object;
}

// The objects that each switch of the page shows and hides.
export const objectsByKind = {shapes: [], skeleton: [], frames: [], coms: [], inertias: [],
  collisions: [], sensors: [], contacts: [], forces: [], loops: [], stops: []};

export function addOfKind(kind, parent, object) {
  parent.add(object);
  objectsByKind[kind].push(object);
  return object;
}

export const grid = new THREE.Group();
scene.add(grid);
export function addGrid(height) {
  const step = 10 ** Math.round(Math.log10(robotSize / 5));
  const cells = 2 * Math.ceil(1.6 * robotSize / step);
  const colors = isDark ? [0x4a5564, 0x2b333e] : [0xaab4c2, 0xd3dae3];
  const lines = new THREE.GridHelper(cells * step, cells, ...colors);
  lines.rotation.x = Math.PI / 2;
  lines.position.z = height - 1e-3 * robotSize;
  grid.add(lines);
}

// --- drawing ---

let needsDrawing = true;
export const requestDrawing = () => { needsDrawing = true; };

// Draw whenever it was requested; onResize is called after the view has changed its size.
export function startDrawing(onResize) {
  const pixelRatio = Math.min(window.devicePixelRatio || 1, 2), canvas = renderer.domElement;
  const drawFrame = () => {
    requestAnimationFrame(drawFrame);
    const width = view.clientWidth, height = view.clientHeight;
    const fits = canvas.width === Math.floor(width * pixelRatio)
      && canvas.height === Math.floor(height * pixelRatio);
    if (width && height && !fits) {
      renderer.setPixelRatio(pixelRatio);
      renderer.setSize(width, height);
      camera.aspect = width / height;
      onResize();
    }
    if (!needsDrawing) return;
    needsDrawing = false;
    renderer.render(scene, camera);
  };
  drawFrame();
}

// The picture that is seen, as a data url.
export function takePicture() {
  renderer.render(scene, camera);
  return renderer.domElement.toDataURL();
}
