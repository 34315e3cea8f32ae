// The page opens: all is built, and a test or a curious reader at the console may ask.

import {byId, data, frames, save, vector} from "./basics.js";
import {aim, extent, fit, steer} from "./camera.js";
import {pick} from "./choose.js";
import {compareShapes, now} from "./compare.js";
import {makeDiagram, makeTables} from "./diagram.js";
import {unpack} from "./geometry.js";
import {beyond, drawMarks, lines, stops} from "./marks.js";
import {makeSliders, makeTree} from "./panel.js";
import {makePlayer, player} from "./player.js";
import {limits, onChange, q, set, settle} from "./positions.js";
import {camera, dark, drawWhenOld, holders, kinds, layGrid, picture, renderer, scene, view}
  from "./scene.js";
import {drawShapes, drawn, missing} from "./shapes.js";
import {begin, blink, bodyOfDrawn, show, update} from "./show.js";

// the moving picture, from one press of the button to the next
let recorder = null;
function record() {
  if (recorder) return recorder.stop();
  const parts = [], type = ["video/webm", "video/mp4"].find((kind) => MediaRecorder.isTypeSupported(kind));
  scene.background = new THREE.Color(dark ? 0x1b222b : 0xf2f5f9);  // the page's is not in the video
  recorder = new MediaRecorder(renderer.domElement.captureStream(), {mimeType: type, videoBitsPerSecond: 8e6});
  recorder.ondataavailable = (event) => parts.push(event.data);
  recorder.onstop = () => {
    recorder = scene.background = null;
    byId("record").textContent = "Record";
    show();
    save(URL.createObjectURL(new Blob(parts, {type})), `${data.name}.${type.slice(6)}`);
  };
  recorder.start();
  byId("record").textContent = "Stop recording";
  show();
}

function openView() {
  view.append(renderer.domElement);
  steer(renderer.domElement, pick);
  byId("fit").onclick = fit;
  byId("picture").onclick = () => save(picture(), `${data.name}.png`);
  byId("record").onclick = record;
  byId("record").hidden = !data.motion || typeof MediaRecorder === "undefined";
  camera.aspect = view.clientWidth / Math.max(view.clientHeight, 1);
  fit();
  drawWhenOld(aim);
}

async function open() {
  await unpack();
  drawShapes();
  drawMarks();
  compareShapes();
  begin();
  const low = extent().min.z;
  layGrid(Number.isFinite(low) ? low : 0);
  if (renderer) openView();
  show();
  if (data.motion) makePlayer();
}

const rows = ({elements: e}) => [0, 1, 2, 3].map((r) => [e[r], e[4 + r], e[8 + r], e[12 + r]]);
const atWorld = (object) => vector().setFromMatrixPosition(object.matrixWorld).toArray();
window.urdf2mbs = {
  set: (name, value) => { set(name, value); settle(); },
  position: (name) => q.get(name),
  limits: (name) => limits.get(name),
  // where a body or a link is drawn
  seen: (side, name) => {
    scene.updateMatrixWorld(true);
    return rows(holders[side].get(name).matrixWorld);
  },
  agreement: () => ({largest: now.largest, compared: now.compared, differing: [...now.differing],
    shapes: now.shapes, shapesDiffering: drawn.filter((one) => one.differs)
      .map((one) => [one.side, one.about, one.differs])}),
  counts: () => ({mbs: drawn.filter((one) => one.side === "mbs").length,
    urdf: drawn.filter((one) => one.side === "urdf").length, lost: missing.length}),
  // the sides on which the shapes of a link's body are seen
  lit: (link) => drawn.filter((one) => one.group.visible && bodyOfDrawn(one) === frames.get(link).body)
    .map((one) => one.side),
  marks: (kind) => {
    scene.updateMatrixWorld(true);
    return kinds[kind].filter((one) => one.visible && one.isMesh).map(atWorld);
  },
  ends: () => lines.map(([line]) => [...line.geometry.attributes.position.array]),
  stops: () => stops.map((one) => ({joint: one.joint.name, low: one.low, high: one.high,
    beyond: beyond(one), hand: rows(one.group.matrix.clone().multiply(one.hand.matrix))})),
  arrows: () => scene.children.filter((one) => one.cone && one.visible).map((one) => one.position.toArray()),
  inertiaCorners: (name) => {
    const box = kinds.inertias.find((one) => one.parent === holders.mbs.get(name));
    const {array} = box.geometry.attributes.position;
    return Array.from({length: array.length / 3},
      (_, k) => vector().fromArray(array, 3 * k).applyMatrix4(box.matrix).toArray());
  },
  picture,
  player,
  blink,
};

makeSliders();
makeTree();
makeDiagram();
makeTables();
onChange(update);
settle();
for (const input of document.querySelectorAll(".view .bar input")) input.onchange = show;
window.urdf2mbs.ready = open();
