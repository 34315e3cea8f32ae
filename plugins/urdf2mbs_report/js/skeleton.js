// The skeletons of both sides, and the frames of bodies and links.

import {data, robotSize, vector} from "./basics.js";
import {solids} from "./geometry.js";
import {addOfKind, getGroup} from "./scene.js";
import {makeMaterial} from "./shapes.js";

// The bones and knobs that are drawn: {side, object}.
export const bones = [];
const BONE_COLORS = {mbs: [0.93, 0.55, 0.12], urdf: [0.35, 0.5, 0.75]};

export function drawSkeletons() {
  const endpoints = data.marks.lines.flatMap(([, first, second]) => [first, second]);
  const bodiesWithEnds = new Set(
    [...data.mbs.bodies.map((body) => body.parent), ...endpoints.map(([body]) => body)]);
  addFrame("frames", "mbs", null, data.frame, 5);
  for (const body of data.mbs.bodies) {
    addFrame("frames", "mbs", body.name, data.frame, 5);
    addKnob("mbs", body.name);
    addBone("mbs", body.parent, body.at);
    if (!bodiesWithEnds.has(body.name)) addBone("mbs", body.name, body.com || [0, 0, 0]);
  }
  for (const link of data.urdf.links) {
    addFrame("frames", "urdf", link.name, data.frame * 1.3, 5);
    addKnob("urdf", link.name);
  }
  for (const joint of data.urdf.joints) addBone("urdf", joint.parent, joint.xyz);
  for (const [body, xyz] of endpoints) addBone("mbs", body, xyz);
}

// Add a bone from the origin of a body or a link to a point of it.
function addBone(side, owner, xyz) {
  const end = vector(...xyz), length = end.length();
  if (length < 1e-9) return;
  const geometry = solids.cylinder(robotSize * 0.0055, length);
  const rod = new THREE.Mesh(geometry, makeMaterial(BONE_COLORS[side], 1, side));
  rod.position.copy(end).multiplyScalar(0.5);
  rod.quaternion.setFromUnitVectors(vector(0, 1, 0), end.clone().divideScalar(length));
  bones.push({side, object: addOfKind("skeleton", getGroup(side, owner), rod)});
}

// Add a ball at the origin of a body or a link.
function addKnob(side, owner) {
  const geometry = solids.ball(robotSize * 0.009);
  const ball = new THREE.Mesh(geometry, makeMaterial(BONE_COLORS[side], 1, side));
  bones.push({side, object: addOfKind("skeleton", getGroup(side, owner), ball)});
}

// Add the axes of a frame, which are seen through all shapes in front of them.
export function addFrame(kind, side, owner, length, renderOrder) {
  const axes = new THREE.AxesHelper(length);
  axes.material.depthTest = false;
  axes.material.transparent = true;
  axes.renderOrder = renderOrder;
  if (side === "urdf") axes.material.opacity = 0.45;
  return addOfKind(kind, getGroup(side, owner), axes);
}
