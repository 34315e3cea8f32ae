// The page opens: all is built, and tests or a curious reader at the console may ask.

import {byId, data, download, linkFrames, vector} from "./basics.js";
import {attachControls, computeRobotBox, fitCamera, updateDepthRange} from "./camera.js";
import {compareShapes, comparison} from "./comparison.js";
import {makeDiagram} from "./diagram.js";
import {blink, measureGaps, startDisplay, updateDisplay, updateScene} from "./display.js";
import {unpackMeshes} from "./geometry.js";
import {MARK_COLORS, drawMarks, hasContacts, loopLines} from "./marks.js";
import {drawMasses} from "./masses.js";
import {makeModes, showPhase} from "./modes.js";
import {foldPanel, makePanelControls, makeSliders, makeTree} from "./panel.js";
import {makePlayer, player} from "./player.js";
import {jointLimits, jointPositions, movePositions, onPositionsChange, updatePositions}
  from "./positions.js";
import {addGrid, camera, groups, isDark, objectsByKind, renderer, scene, startDrawing, takePicture,
  view} from "./scene.js";
import {onSelectionChange, selectAt} from "./selection.js";
import {drawShapes, drawStandIns, drawnShapes, findBodyOfShape, missingMeshes} from "./shapes.js";
import {drawSkeletons} from "./skeleton.js";
import {drawStops, isBeyondStop, stops} from "./stops.js";
import {makeLinks, makeTables} from "./tables.js";

async function open() {
  await unpackMeshes();
  drawShapes();
  drawSkeletons();
  drawMasses();
  drawMarks();
  drawStops();
  for (const kind of Object.keys(MARK_COLORS)) {
    const isElsewhere = kind === "contacts" ? hasContacts : kind === "forces" && data.motion;
    byId(`show-${kind}`).parentNode.hidden = !objectsByKind[kind].length && !isElsewhere;
  }
  compareShapes();
  drawStandIns();
  startDisplay();
  const lowest = computeRobotBox().min.z;
  addGrid(Number.isFinite(lowest) ? lowest : 0);
  if (renderer) openView();
  updateDisplay();
  if (data.motion) makePlayer();
  if (data.modes) makeModes();
  if (renderer) fitCamera();  // to the whole motion
}

function openView() {
  view.append(renderer.domElement);
  attachControls(renderer.domElement, selectAt);
  byId("fit").onclick = fitCamera;
  byId("picture").onclick = () => download(takePicture(), `${data.name}.png`);
  byId("record").onclick = toggleRecording;
  byId("record").hidden = !(data.motion || data.modes) || typeof MediaRecorder === "undefined";
  camera.aspect = view.clientWidth / Math.max(view.clientHeight, 1);
  startDrawing(updateDepthRange);
}

// The recorder of a video, from one press of the button to the next.
let recorder = null;

function toggleRecording() {
  if (recorder) return recorder.stop();
  const pieces = [];
  const mimeType = ["video/webm", "video/mp4"].find((type) => MediaRecorder.isTypeSupported(type));
  // The background of the page is not in the video.
  scene.background = new THREE.Color(isDark ? 0x1b222b : 0xf2f5f9);
  const stream = renderer.domElement.captureStream();
  recorder = new MediaRecorder(stream, {mimeType, videoBitsPerSecond: 8e6});
  recorder.ondataavailable = (event) => pieces.push(event.data);
  recorder.onstop = () => {
    recorder = scene.background = null;
    byId("record").textContent = "Record";
    updateDisplay();
    const video = new Blob(pieces, {type: mimeType});
    download(URL.createObjectURL(video), `${data.name}.${mimeType.slice("video/".length)}`);
  };
  recorder.start();
  byId("record").textContent = "Stop recording";
  updateDisplay();
}

// --- for tests and the console ---

const listRows = ({elements}) => [0, 1, 2, 3].map(
  (row) => [elements[row], elements[4 + row], elements[8 + row], elements[12 + row]]);
const listPosition = (object) => vector().setFromMatrixPosition(object.matrixWorld).toArray();
const countShapes = (side) =>
  drawnShapes.filter((shape) => shape.side === side && !shape.isStandIn).length;

Object.assign(window.urdf2mbs, {
  set: (name, value) => movePositions(new Map([[name, value]])),
  position: (name) => jointPositions.get(name),
  limits: (name) => jointLimits.get(name),
  // The pose in which a body ("mbs") or a link ("urdf") is drawn.
  seen: (side, name) => {
    scene.updateMatrixWorld(true);
    return listRows(groups[side].get(name).matrixWorld);
  },
  agreement: () => ({
    largest: comparison.largestDeviation, compared: comparison.comparedLinks,
    differing: [...comparison.differingLinks], shapes: comparison.equalShapes,
    shapesDiffering: drawnShapes.filter((shape) => shape.difference)
      .map(({side, label, difference}) => [side, label, difference]),
  }),
  counts: () => ({mbs: countShapes("mbs"), urdf: countShapes("urdf"), lost: missingMeshes.length}),
  // The sides on which the shapes of a link's body are seen.
  lit: (link) => {
    const {body} = linkFrames.get(link);
    return drawnShapes.filter((shape) => shape.group.visible && findBodyOfShape(shape) === body)
      .map((shape) => shape.side);
  },
  marks: (kind) => {
    scene.updateMatrixWorld(true);
    return objectsByKind[kind].filter((object) => object.visible && object.isMesh).map(listPosition);
  },
  ends: () => loopLines.map(({line}) => [...line.geometry.attributes.position.array]),
  stops: () => stops.map((stop) => ({
    joint: stop.joint.name, low: stop.low, high: stop.high, beyond: isBeyondStop(stop),
    hand: listRows(stop.group.matrix.clone().multiply(stop.hand.matrix)),
  })),
  arrows: () => scene.children.filter((object) => object.cone && object.visible)
    .map((arrow) => arrow.position.toArray()),
  inertiaCorners: (name) => {
    const box = objectsByKind.inertias.find((object) => object.parent === groups.mbs.get(name));
    const {array} = box.geometry.attributes.position;
    return Array.from({length: array.length / 3},
      (_, corner) => vector().fromArray(array, 3 * corner).applyMatrix4(box.matrix).toArray());
  },
  // Of each loop, by how much it is open (m).
  gaps: () => measureGaps(),
  camera: () => camera.position.toArray(),
  picture: takePicture,
  player,
  showPhase,
  blink,
});

makeSliders();
makeTree();
makePanelControls();
makeDiagram();
makeTables();
makeLinks();
foldPanel();
onPositionsChange(updateScene);
onSelectionChange(updateDisplay);
updatePositions();
for (const input of document.querySelectorAll(".view .bar input")) input.onchange = updateDisplay;
window.urdf2mbs.opened = open();
