// The poses of bodies and links: the .mbs and the URDF, each by its own calculation.

import {coordinatesOfJoint, data, matrix, translation, vector} from "./basics.js";

// The elementary joints of an .mbs, each in the axes of the frame before it.
export const JOINT_TRANSFORMS = {
  T1: (q) => translation([q, 0, 0]),
  T2: (q) => translation([0, q, 0]),
  T3: (q) => translation([0, 0, q]),
  R1: (q) => matrix().makeRotationX(q),
  R2: (q) => matrix().makeRotationY(q),
  R3: (q) => matrix().makeRotationZ(q),
};

// The poses of bodies, and of the frames after joints, by their names; null is the base.
export function computeMbsPoses(jointPositions) {
  const bodies = new Map([[null, matrix()]]), joints = new Map();
  for (const body of data.mbs.bodies) {
    const pose = bodies.get(body.parent).clone().multiply(translation(body.at));
    for (const {name, type, q} of body.joints) {
      const position = jointPositions.has(name) ? jointPositions.get(name) : q || 0;
      pose.multiply(JOINT_TRANSFORMS[type](position));
      joints.set(name, pose.clone());
    }
    bodies.set(body.name, pose);
  }
  return {bodies, joints};
}

// The poses of links by their names.
export function computeUrdfPoses(jointPositions) {
  const links = new Map([[data.urdf.root, matrix()]]);
  for (const joint of data.urdf.joints) {
    const pose = links.get(joint.parent).clone().multiply(computeOrigin(joint.xyz, joint.rpy));
    const coordinates = coordinatesOfJoint.get(joint.name);
    if (joint.type !== "fixed" && coordinates) {
      pose.multiply(computeMotion(joint, coordinates.map((name) => jointPositions.get(name) || 0)));
    }
    links.set(joint.child, pose);
  }
  return links;
}

// Fixed-frame roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll).
export const computeOrigin = (xyz, [roll, pitch, yaw]) => translation(xyz)
  .multiply(rotateAbout(Z, yaw)).multiply(rotateAbout(Y, pitch)).multiply(rotateAbout(X, roll));

const X = vector(1, 0, 0), Y = vector(0, 1, 0), Z = vector(0, 0, 1);
const rotateAbout = (axis, angle) => matrix().makeRotationAxis(axis, angle);  // Rodrigues' formula
const translateAlong = (axis, length) => translation(axis.clone().multiplyScalar(length).toArray());

// The motion of a URDF joint at the values of its coordinates.
function computeMotion(joint, values) {
  if (joint.type === "floating") {
    const [roll, pitch, yaw] = values.slice(3);
    return translation(values.slice(0, 3))
      .multiply(rotateAbout(X, roll)).multiply(rotateAbout(Y, pitch)).multiply(rotateAbout(Z, yaw));
  }
  // Divided by its largest element first, a tiny axis does not underflow.
  const largest = Math.max(...joint.axis.map(Math.abs));
  const axis = vector(...joint.axis).divideScalar(largest).normalize();
  if (joint.type === "planar") {
    const [first, second] = computePlaneAxes(axis);
    return translateAlong(first, values[0]).multiply(translateAlong(second, values[1]))
      .multiply(rotateAbout(axis, values[2]));
  }
  return joint.type === "prismatic" ? translateAlong(axis, values[0]) : rotateAbout(axis, values[0]);
}

// The two directions in which a planar joint shifts, which URDF does not define.
function computePlaneAxes({x, y, z}) {
  const tiny = 1e-9;
  let first = vector(-y, x, 0).normalize();
  if (Math.abs(x) <= tiny && Math.abs(y) > tiny) first = vector(0, -z, y);
  else if (Math.abs(y) <= tiny && Math.abs(z) > tiny) first = vector(z, 0, -x);
  return [first, vector(x, y, z).cross(first)];
}
