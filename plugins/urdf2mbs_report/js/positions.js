// The positions of joints (rad, m), their limits, and the joints that follow others by <mimic>.

import {byId, coordinatesOfJoint, data, isModelAlone, robotSize} from "./basics.js";

// By the names of the .mbs's joints.
export const jointPositions = new Map();
export const jointLimits = new Map();
// Of a joint that follows another one: [leader, factor, offset].
export const followers = new Map();
export const movingJoints = data.mbs.bodies.flatMap((body) => body.joints)
  .filter((joint) => isModelAlone || joint.nature !== "driven");
// The coordinates of the URDF's floating joints.
export const floatingCoordinates = new Set(
  data.urdf.joints.filter((joint) => joint.type === "floating")
    .flatMap((joint) => coordinatesOfJoint.get(joint.name) || []));

for (const joint of movingJoints) {
  const limit = joint.type[0] === "R" ? Math.PI : Math.max(robotSize, 0.1);
  jointLimits.set(joint.name, [-limit, limit]);
}
for (const joint of data.urdf.joints) {
  const coordinates = coordinatesOfJoint.get(joint.name);
  if (!coordinates || coordinates.length !== 1) continue;
  const [low, high] = joint.limit || [0, 0];
  if (joint.type !== "continuous" && low < high) jointLimits.set(coordinates[0], [low, high]);
  if (!joint.mimic) continue;
  const [leader, factor, offset] = joint.mimic;
  if (coordinatesOfJoint.has(leader)) {
    followers.set(coordinates[0], [coordinatesOfJoint.get(leader)[0], factor, offset]);
  }
}

// Set a position within its limits; updatePositions shows it.
export function setPosition(name, value) {
  const [low, high] = jointLimits.get(name);
  jointPositions.set(name, Math.min(Math.max(Number.isFinite(value) ? value : 0, low), high));
}
for (const joint of movingJoints) setPosition(joint.name, joint.q || 0);

const listeners = [];
// The listener is called after each change of positions.
export const onPositionsChange = (listener) => listeners.push(listener);

// Move the joints that follow others, and show all positions.
export function updatePositions() {
  // Followers may follow followers: a chain of n needs n rounds.
  for (let round = 0; byId("mimic").checked && round < followers.size; round++) {
    let hasChanged = false;
    for (const [name, [leader, factor, offset]] of followers) {
      const position = factor * jointPositions.get(leader) + offset;
      hasChanged = hasChanged || position !== jointPositions.get(name);
      jointPositions.set(name, position);
    }
    if (!hasChanged) break;
  }
  for (const listener of listeners) listener();
}
