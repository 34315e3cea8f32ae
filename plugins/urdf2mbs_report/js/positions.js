// The positions of joints (rad, m), their limits, and the joints that follow others.

import {alone, byId, coordinates, data, size} from "./basics.js";

export const q = new Map();
export const limits = new Map();
export const follows = new Map();
export const moving = data.mbs.bodies.flatMap((body) => body.joints)
  .filter((joint) => alone || joint.nature !== "driven");
// the coordinates of the URDF's floating joints
export const floating = new Set(data.urdf.joints.filter((joint) => joint.type === "floating")
  .flatMap((joint) => coordinates.get(joint.name) || []));

for (const joint of moving) {
  const reach = joint.type[0] === "R" ? Math.PI : Math.max(size, 0.1);
  limits.set(joint.name, [-reach, reach]);
}
for (const joint of data.urdf.joints) {
  const names = coordinates.get(joint.name);
  if (!names || names.length !== 1) continue;
  const [low, high] = joint.limit || [0, 0];
  if (joint.type !== "continuous" && low < high) limits.set(names[0], [low, high]);
  if (joint.mimic && coordinates.has(joint.mimic[0])) {
    follows.set(names[0], [coordinates.get(joint.mimic[0])[0], joint.mimic[1], joint.mimic[2]]);
  }
}

export function set(name, value) {
  const [low, high] = limits.get(name);
  q.set(name, Math.min(Math.max(Number.isFinite(value) ? value : 0, low), high));
}
for (const joint of moving) set(joint.name, joint.q || 0);

const shown = [];
// what shows positions is called after each change
export const onChange = (show) => shown.push(show);

// let followers follow, and show the positions
export function settle() {
  for (let round = 0; byId("mimic").checked && round < follows.size; round++) {
    let changed = false;
    for (const [name, [leader, factor, offset]] of follows) {
      const value = factor * q.get(leader) + offset;
      changed = changed || value !== q.get(name);
      q.set(name, value);
    }
    if (!changed) break;
  }
  for (const show of shown) show();
}
