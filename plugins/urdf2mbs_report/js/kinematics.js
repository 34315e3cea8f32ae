// Where bodies and links are: the .mbs and the URDF, each by its own calculation.

import {coordinates, data, matrix, shift, vector} from "./basics.js";

// the elementary joints of an .mbs, each in the current frame
export const ELEMENTARY = {
  T1: (q) => shift([q, 0, 0]),
  T2: (q) => shift([0, q, 0]),
  T3: (q) => shift([0, 0, q]),
  R1: (q) => matrix().makeRotationX(q),
  R2: (q) => matrix().makeRotationY(q),
  R3: (q) => matrix().makeRotationZ(q),
};

// the poses of bodies, and of the frames after joints
export function mbsPoses(q) {
  const bodies = new Map([[null, matrix()]]), joints = new Map();
  for (const body of data.mbs.bodies) {
    const pose = bodies.get(body.parent).clone().multiply(shift(body.at));
    for (const joint of body.joints) {
      const value = q.has(joint.name) ? q.get(joint.name) : joint.q || 0;
      pose.multiply(ELEMENTARY[joint.type](value));
      joints.set(joint.name, pose.clone());
    }
    bodies.set(body.name, pose);
  }
  return {bodies, joints};
}

const X = vector(1, 0, 0), Y = vector(0, 1, 0), Z = vector(0, 0, 1);
const turnAbout = (axis, angle) => matrix().makeRotationAxis(axis, angle);  // Rodrigues' formula
const slide = (axis, by) => shift(axis.clone().multiplyScalar(by).toArray());

// fixed-frame roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll)
export const origin = (xyz, [roll, pitch, yaw]) => shift(xyz)
  .multiply(turnAbout(Z, yaw)).multiply(turnAbout(Y, pitch)).multiply(turnAbout(X, roll));

// the two directions in which a planar joint shifts, which URDF leaves open
function inPlane({x, y, z}) {
  const tiny = 1e-9;
  let u = vector(-y, x, 0).normalize();
  if (Math.abs(x) <= tiny && Math.abs(y) > tiny) u = vector(0, -z, y);
  else if (Math.abs(y) <= tiny && Math.abs(z) > tiny) u = vector(z, 0, -x);
  return [u, vector(x, y, z).cross(u)];
}

function motion(joint, values) {
  if (joint.type === "floating") {
    const [roll, pitch, yaw] = values.slice(3);
    return shift(values.slice(0, 3))
      .multiply(turnAbout(X, roll)).multiply(turnAbout(Y, pitch)).multiply(turnAbout(Z, yaw));
  }
  const axis = vector(...joint.axis).divideScalar(Math.max(...joint.axis.map(Math.abs))).normalize();
  if (joint.type === "planar") {
    const [u, v] = inPlane(axis);
    return slide(u, values[0]).multiply(slide(v, values[1])).multiply(turnAbout(axis, values[2]));
  }
  return joint.type === "prismatic" ? slide(axis, values[0]) : turnAbout(axis, values[0]);
}

export function urdfPoses(q) {
  const links = new Map([[data.urdf.root, matrix()]]);
  for (const joint of data.urdf.joints) {
    const pose = links.get(joint.parent).clone().multiply(origin(joint.xyz, joint.rpy));
    const names = coordinates.get(joint.name);
    if (joint.type !== "fixed" && names) {
      pose.multiply(motion(joint, names.map((name) => q.get(name) || 0)));
    }
    links.set(joint.child, pose);
  }
  return links;
}
