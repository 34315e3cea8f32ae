// The marks of sensors, contacts, forces and loops, which are seen through all shapes.

import {data, poseOf, robotSize, vector} from "./basics.js";
import {solids} from "./geometry.js";
import {addOfKind, getGroup, objectsByKind, setPose, sideGroups} from "./scene.js";
import {addFrame} from "./skeleton.js";

export const MARK_COLORS = {sensors: 0x0097a7, contacts: 0xd84315, forces: 0xad1457, loops: 0x2e7d32,
  stops: 0x1565c0};

// Contacts are many: their dots are made when they are first shown.
const contactMarks = data.marks.points.filter(([, , kind]) => kind === "contacts");
export const hasContacts = contactMarks.length > 0;
// A contact that is no higher above the ground touches it (m).
const TOUCHING = 2e-3;

// The lines of cuts and links: {line, first, second}, whose ends are [body, xyz].
export const loopLines = [];

export function drawMarks() {
  // The arrows of a motion show where forces act; modes are free of them.
  const isMoving = data.motion || data.modes;
  const isDrawn = (kind) => kind !== "contacts" && !(kind === "forces" && isMoving);
  data.marks.points.filter(([, , kind]) => isDrawn(kind)).forEach(addPointMark);
  data.marks.lines.forEach(addLoopLine);
}

// Show the contacts that touch the ground, and those of the body that is selected.
export function showContacts(isOn, selectedBody, bodyPoses) {
  const dots = objectsByKind.contacts;
  if (isOn && !dots.length) contactMarks.forEach(addPointMark);
  dots.forEach((dot, k) => {
    const [body] = contactMarks[k];
    const height = isOn ? dot.position.clone().applyMatrix4(bodyPoses.get(body)).z : 0;
    dot.visible = isOn && (body === selectedBody || height <= data.marks.ground + TOUCHING);
  });
}

// The other marks move with the groups of their bodies.
export function moveLoopLines(bodyPoses) {
  const locate = ([body, xyz]) => vector(...xyz).applyMatrix4(bodyPoses.get(body));
  for (const {line, first, second} of loopLines) {
    line.geometry.setFromPoints([locate(first), locate(second)]);
  }
}

export function makeMarkMaterial(kind, Material = THREE.MeshBasicMaterial) {
  return new Material({color: MARK_COLORS[kind], transparent: true, opacity: 0.85, depthTest: false});
}

function addDot(kind, body, xyz) {
  const ball = new THREE.Mesh(solids.ball(robotSize * 0.007), makeMarkMaterial(kind));
  ball.position.set(...xyz);
  ball.renderOrder = 6;
  addOfKind(kind, getGroup("mbs", body), ball);
}

function addPointMark([body, xyz, kind, rotation]) {
  addDot(kind, body, xyz);
  if (rotation) setPose(addFrame(kind, "mbs", body, data.frame, 6), poseOf(rotation, xyz));
}

// Add a line between the ends of a cut or a link.
function addLoopLine([, first, second]) {
  for (const [body, xyz] of [first, second]) addDot("loops", body, xyz);
  const material = makeMarkMaterial("loops", THREE.LineBasicMaterial);
  const line = new THREE.Line(new THREE.BufferGeometry(), material);
  line.renderOrder = 6;
  line.frustumCulled = false;
  loopLines.push({line: addOfKind("loops", sideGroups.mbs, line), first, second});
}
