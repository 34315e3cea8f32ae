// The comparison of the two sides: the frames of links at each position, and the shapes once.

import {data, findBodyOfLink, isModelAlone, linkFrames, linksOfBody, matrix, poseOf, robotSize}
  from "./basics.js";
import {measureSurface} from "./geometry.js";
import {computeMbsPoses, computeUrdfPoses} from "./kinematics.js";
import {jointPositions} from "./positions.js";
import {drawnShapes} from "./shapes.js";

// A larger deviation of a frame, relative to the size of the robot, is a difference.
const FRAME_TOLERANCE = 1e-6;
// A larger deviation of a colour, of 0 to 1, is a difference.
const COLOR_TOLERANCE = 0.004;

// The poses of both sides at the current position, and what differs.
export const comparison = {
  mbs: null,  // poses of bodies and joints
  links: null,  // poses of links
  differingLinks: new Set(),
  comparedLinks: 0,
  largestDeviation: 0,  // of rotations and, relative to the size of the robot, of origins
  largestDistance: 0,  // of origins (m)
  equalShapes: 0,
};

export function comparePoses() {
  Object.assign(comparison, {
    mbs: computeMbsPoses(jointPositions), links: computeUrdfPoses(jointPositions),
    differingLinks: new Set(), comparedLinks: 0, largestDeviation: 0, largestDistance: 0,
  });
  for (const [link, urdfPose] of comparison.links) {
    const frame = linkFrames.get(link);
    if (!frame) continue;
    const {bodies, joints} = comparison.mbs;
    const holderPose = frame.joint === null ? bodies.get(frame.body) : joints.get(frame.joint);
    const mbsPose = holderPose.clone().multiply(poseOf(frame.pose.slice(0, 9), frame.pose.slice(9)));
    const deviations = urdfPose.elements.map((value, k) => Math.abs(value - mbsPose.elements[k]));
    const distance = Math.max(...deviations.slice(12));
    const deviation = Math.max(...deviations.slice(0, 12), distance / robotSize);
    comparison.comparedLinks++;
    comparison.largestDeviation = Math.max(comparison.largestDeviation, deviation);
    comparison.largestDistance = Math.max(comparison.largestDistance, distance);
    if (!(deviation <= FRAME_TOLERANCE)) comparison.differingLinks.add(link);  // NaN, too
  }
}

// Give each visual its counterpart: the shape of the .mbs with the same surface.  Shapes without
// one differ, unless a mesh of their body or link is missing.
export function compareShapes() {
  comparePoses();
  if (isModelAlone) return;
  const unmatched = drawnShapes.filter((shape) => shape.side === "mbs" && !shape.isStandIn)
    .map((shape) => ({shape, surface: measureShape(shape, matrix())}));
  const lacksMesh = (shape) => shape.mesh === null;
  const incompleteBodies = new Set(
    [{name: null, shapes: data.mbs.base.shapes}, ...data.mbs.bodies]
      .filter((body) => body.shapes.some(lacksMesh)).map((body) => body.name));
  const bodiesOfIncompleteLinks = new Set(
    data.urdf.links.filter((link) => link.visuals.some(lacksMesh))
      .map((link) => findBodyOfLink(link.name)));
  for (const visual of drawnShapes.filter((shape) => shape.side === "urdf")) {
    const body = findBodyOfLink(visual.owner), bodyPose = comparison.mbs.bodies.get(body);
    if (!bodyPose) continue;
    const linkInBody = bodyPose.clone().invert().multiply(comparison.links.get(visual.owner));
    const surface = measureShape(visual, linkInBody);
    const index = unmatched.findIndex(
      (mbs) => mbs.shape.owner === body && areEqualSurfaces(surface, mbs.surface));
    if (index >= 0) {
      const [{shape: counterpart}] = unmatched.splice(index, 1);
      comparison.equalShapes++;
      visual.counterpart = counterpart;
      if (haveDifferentColors(visual, counterpart)) {
        visual.difference = counterpart.difference = "in colour";
      }
    } else if (!incompleteBodies.has(body)) {
      visual.difference = "in form or place";
    }
  }
  for (const {shape} of unmatched) {
    if (!bodiesOfIncompleteLinks.has(shape.owner)) shape.difference = "in form or place";
  }
}

// The surface of a shape, in the frame of its body.
function measureShape(shape, ownerInBody) {
  return measureSurface(shape.meshes, ownerInBody.multiply(shape.group.matrix));
}

// Surfaces are equal to a thousandth of their extent.
function areEqualSurfaces(a, b) {
  const extent = Math.sqrt(Math.abs(a.moments[0] + a.moments[3] + a.moments[5])) || 1e-6;
  const tolerance = 1e-3 * extent + 1e-6 * robotSize;
  return Math.abs(a.area - b.area) <= 2e-3 * Math.max(a.area, b.area)
    && a.centre.every((value, k) => Math.abs(value - b.centre[k]) <= tolerance)
    && a.moments.every((value, k) => Math.abs(value - b.moments[k]) <= 4 * tolerance * extent);
}

function haveDifferentColors({color: a}, {color: b}) {
  return a && b && a.some((value, k) => Math.abs(value - b[k]) > COLOR_TOLERANCE);
}

// True if a shape differs in form or place, or a link that has it is elsewhere.
export function isDifferent(shape) {
  if (shape.difference === "in form or place") return true;
  const links = shape.side === "urdf" ? [shape.owner] : linksOfBody.get(shape.owner) || [];
  return links.some((link) => comparison.differingLinks.has(link));
}
