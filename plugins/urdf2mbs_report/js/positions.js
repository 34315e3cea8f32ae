// The positions of joints (rad, m), their limits, and the joints that follow others by <mimic>.

import {byId, coordinatesOfJoint, data, robotSize} from "./basics.js";
import {closeLoops, cuts, loopJoints} from "./loops.js";

const allJoints = data.mbs.bodies.flatMap((body) => body.joints);
// The joints that a user moves: driven ones are ruled by the model.
export const movingJoints = allJoints.filter((joint) => joint.nature !== "driven");
// By the names of the .mbs's joints.
export const jointPositions = new Map(allJoints.map((joint) => [joint.name, joint.q || 0]));
export const jointLimits = new Map();
// Of a joint that follows another one: [leader, factor, offset].
export const followers = new Map(
  data.followers.map(([name, leader, factor, offset]) => [name, [leader, factor, offset]]));
// The joints of a floating base.
export const baseJoints = new Set(
  data.urdf.joints.filter((joint) => joint.type === "floating")
    .flatMap((joint) => coordinatesOfJoint.get(joint.name) || []));

// A body on the ground floats if its first six joints are three translations and three rotations.
for (const {parent, joints} of data.mbs.bodies) {
  const first = joints.slice(0, 6), kinds = first.map(({type}) => type[0]).sort().join("");
  if (parent === null && kinds === "RRRTTT") first.forEach(({name}) => baseJoints.add(name));
}

for (const {name, type, q} of movingJoints) {
  const range = type[0] === "R" ? Math.PI : Math.max(robotSize, 0.1), start = q || 0;
  jointLimits.set(name, [Math.min(-range, start - range), Math.max(range, start + range)]);
}
for (const [name, [low, high]] of data.marks.stops) {
  const limits = jointLimits.get(name);
  if (limits && !(low >= high)) jointLimits.set(name, [low ?? limits[0], high ?? limits[1]]);
}
for (const joint of data.urdf.joints) {
  const coordinates = coordinatesOfJoint.get(joint.name);
  if (!coordinates || coordinates.length !== 1) continue;
  const [low, high] = joint.limit || [0, 0];
  if (joint.type !== "continuous" && low < high) jointLimits.set(coordinates[0], [low, high]);
}

// Set a position within its limits; updatePositions shows it.
export function setPosition(name, value) {
  const [low, high] = jointLimits.get(name);
  jointPositions.set(name, Math.min(Math.max(Number.isFinite(value) ? value : 0, low), high));
}

const listeners = [];
// The listener is called after each change of positions.
export const onPositionsChange = (listener) => listeners.push(listener);

// Show all positions as they are, such as those of a motion.
export const showPositions = () => listeners.forEach((listener) => listener());

// Move the joints that follow others, and show all positions.
export function updatePositions() {
  applyFollowers();
  showPositions();
}

export const isFollower = (name) => byId("mimic").checked && followers.has(name);

// Followers may follow followers: a chain of n needs n rounds.
function applyFollowers() {
  for (let round = 0; byId("mimic").checked && round < followers.size; round++) {
    let hasChanged = false;
    for (const [name, [leader, factor, offset]] of followers) {
      const position = factor * jointPositions.get(leader) + offset;
      hasChanged = hasChanged || position !== jointPositions.get(name);
      jointPositions.set(name, position);
    }
    if (!hasChanged) break;
  }
}

// Show the positions of the file, also where they are beyond limits, or a loop is open.
export function showStart() {
  for (const {name, q} of allJoints) jointPositions.set(name, q || 0);
  showPositions();
}

// --- moving where loops are closed ---

const MAX_MOVE = 0.1;  // of a joint from one pose to the next (rad, m)
const MAX_POSES = 60;

// Move joints to targets, by their names; loops stay closed, and stop a move that would open them.
export function movePositions(targets) {
  const begins = new Map([...targets.keys()].map((name) => [name, jointPositions.get(name)]));
  const changes = [...targets].map(([name, target]) => Math.abs(target - begins.get(name)));
  const isClosed = !cuts.length || closeAllLoops(new Set());
  const longest = Math.max(0, ...changes) / MAX_MOVE;
  const count = cuts.length && isClosed ? Math.min(Math.ceil(longest), MAX_POSES) : 1;
  for (let pose = 1; pose <= count; pose++) {
    const before = new Map(jointPositions);
    for (const [name, target] of targets) {
      const begin = begins.get(name);
      setPosition(name, pose === count ? target : begin + (target - begin) * pose / count);
    }
    applyFollowers();
    if (cuts.length && !closeAllLoops(new Set(targets.keys())) && isClosed) {
      assignPositions(before);
      break;
    }
  }
  updatePositions();
}

// Close the loops: by dependent joints, else by all that are not held, else by all but the base.
// Returns false if they cannot close; then the dependent joints are as near as they come.
function closeAllLoops(held) {
  const names = [...loopJoints.values()].filter(({name}) =>
    jointLimits.has(name) && !baseJoints.has(name) && !isFollower(name));
  const choices = [({name, nature}) => nature === "dependent" && !held.has(name),
    ({name}) => !held.has(name), () => true];
  const before = new Map(jointPositions);
  let nearest = null;
  for (const isChosen of choices) {
    assignPositions(before);
    const chosen = names.filter(isChosen).map(({name}) => name);
    if (closeLoops(jointPositions, chosen, jointLimits, applyFollowers)) return true;
    nearest = nearest || new Map(jointPositions);
  }
  assignPositions(nearest);
  return false;
}

// Close the loops at positions that were set for all joints; an open one is said to be open.
export const closeShownLoops = () => cuts.length && closeAllLoops(new Set());

function assignPositions(positions) {
  for (const [name, position] of positions) jointPositions.set(name, position);
}

// Move all joints but the base; loops decide where their dependent joints are.
export function moveAll(choosePosition) {
  const isMoved = ({name, nature}) => !baseJoints.has(name) && !isFollower(name)
    && !(nature === "dependent" && loopJoints.has(name));
  movePositions(new Map(movingJoints.filter(isMoved).map((joint) => {
    const [low, high] = jointLimits.get(joint.name);
    return [joint.name, Math.min(Math.max(choosePosition(joint), low), high)];
  })));
}
