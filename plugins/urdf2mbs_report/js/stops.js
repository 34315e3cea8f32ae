// The stops of joints: their range from limit to limit, and a hand at their position.

import {data, jointByName, matrix, robotSize, vector} from "./basics.js";
import {solids} from "./geometry.js";
import {JOINT_TRANSFORMS} from "./kinematics.js";
import {MARK_COLORS, makeMarkMaterial} from "./marks.js";
import {jointLimits, jointPositions} from "./positions.js";
import {addOfKind, setPose, sideGroups} from "./scene.js";

// {joint, low, high (null: no limit), group, hand}
export const stops = [];
const BEYOND_COLOR = 0xd6273b;

export function drawStops() {
  for (const [name, limits] of data.marks.stops) {
    if (jointLimits.has(name)) addStop(jointByName.get(name).joint, limits);
  }
}

export function isBeyondStop({joint, low, high}) {
  const position = jointPositions.get(joint.name);
  return low !== null && position < low - 1e-9 || high !== null && position > high + 1e-9;
}

// The range is drawn from the joint at zero, and the hand moves with the joint.
export function moveStops(jointPoses) {
  for (const stop of stops) {
    const {joint, group, hand} = stop;
    const motion = JOINT_TRANSFORMS[joint.type](jointPositions.get(joint.name));
    group.matrix.copy(jointPoses.get(joint.name)).multiply(motion.clone().invert());
    hand.matrix.copy(motion);
    const color = isBeyondStop(stop) ? BEYOND_COLOR : MARK_COLORS.stops;
    group.traverse(({material}) => material && material.color.set(color));
  }
}

function addStop(joint, [low, high]) {
  const addRange = joint.type[0] === "R" ? addAngleRange : addLengthRange;
  const group = new THREE.Group(), hand = new THREE.Group();
  addRange(group, hand, +joint.type[1] - 1, low, high);
  group.matrixAutoUpdate = hand.matrixAutoUpdate = false;
  group.add(hand);
  group.traverse((object) => { object.renderOrder = 7; });
  stops.push({joint, low, high, group: addOfKind("stops", sideGroups.mbs, group), hand});
}

const STOP_RADIUS = robotSize * 0.05;
const unitVector = (axis) => vector().setComponent(axis % 3, 1);
// The pose whose z is along an axis (0, 1 or 2).
const turnZTo = (axis) =>
  matrix().makeBasis(unitVector(axis + 1), unitVector(axis + 2), unitVector(axis));

// Add a sector of a ring, and a hand across the axis of a revolute joint.
function addAngleRange(group, hand, axis, low, high) {
  const from = low === null ? -Math.PI : low, to = high === null ? Math.PI : high;
  const angle = Math.min(to - from, 2 * Math.PI);
  const sector = makeRing(STOP_RADIUS * 0.55, STOP_RADIUS, 40, 1, from, angle);
  sector.material.opacity = 0.45;
  group.add(setPose(sector, turnZTo(axis)));
  hand.add(makeStopLine([vector(), unitVector(axis + 1).multiplyScalar(STOP_RADIUS * 1.2)]));
}

// Add a line with a disc at each limit, and a ball as the hand of a prismatic joint.
function addLengthRange(group, hand, axis, low, high) {
  const ends = [low === null ? -STOP_RADIUS : low, high === null ? STOP_RADIUS : high];
  group.add(makeStopLine(ends.map((end) => unitVector(axis).multiplyScalar(end))));
  for (const limit of [low, high]) {
    if (limit === null) continue;
    const pose = turnZTo(axis).setPosition(unitVector(axis).multiplyScalar(limit));
    group.add(setPose(makeRing(0, STOP_RADIUS * 0.4, 20), pose));
  }
  hand.add(new THREE.Mesh(solids.ball(STOP_RADIUS * 0.15), makeMarkMaterial("stops")));
}

function makeRing(...parameters) {
  const ring = new THREE.Mesh(new THREE.RingGeometry(...parameters), makeMarkMaterial("stops"));
  ring.material.side = THREE.DoubleSide;
  return ring;
}

function makeStopLine(points) {
  return new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
    makeMarkMaterial("stops", THREE.LineBasicMaterial));
}
