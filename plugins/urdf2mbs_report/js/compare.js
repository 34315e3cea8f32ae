// The two sides compared: the frames of links at this position, and the shapes once.

import {alone, bodyOfLink, data, frames, linksOf, matrix, size} from "./basics.js";
import {surface} from "./geometry.js";
import {mbsPoses, urdfPoses} from "./kinematics.js";
import {rowMajor} from "./marks.js";
import {q} from "./positions.js";
import {drawn} from "./shapes.js";

// the poses now; links whose frames differ; the largest difference, relative and in m
export const now = {mbs: null, links: null, differing: new Set(), largest: 0, farthest: 0, compared: 0,
  shapes: 0};

export function evaluate() {
  Object.assign(now, {mbs: mbsPoses(q), links: urdfPoses(q), differing: new Set(), largest: 0,
    farthest: 0, compared: 0});
  for (const [link, pose] of now.links) {
    const at = frames.get(link);
    if (!at) continue;
    const held = (at.joint === null ? now.mbs.bodies.get(at.body) : now.mbs.joints.get(at.joint))
      .clone().multiply(rowMajor(at.pose.slice(0, 9), at.pose.slice(9)));
    const off = pose.elements.map((value, k) => Math.abs(value - held.elements[k]));
    const along = Math.max(...off.slice(12)), apart = Math.max(...off.slice(0, 12), along / size);
    now.compared++;
    now.largest = Math.max(now.largest, apart);
    now.farthest = Math.max(now.farthest, along);
    if (!(apart <= 1e-6)) now.differing.add(link);
  }
}

// equal surfaces, to a thousandth of their extent
function alike(a, b) {
  const extent = Math.sqrt(Math.abs(a.moments[0] + a.moments[3] + a.moments[5])) || 1e-6;
  const tolerance = 1e-3 * extent + 1e-6 * size;
  return Math.abs(a.area - b.area) <= 2e-3 * Math.max(a.area, b.area)
    && a.centre.every((c, k) => Math.abs(c - b.centre[k]) <= tolerance)
    && a.moments.every((m, k) => Math.abs(m - b.moments[k]) <= 4 * tolerance * extent);
}

// give each shape of the URDF its twin: the shape of the .mbs with the same surface
export function compareShapes() {
  evaluate();
  if (alone) return;
  const measured = (one, pose) => surface(one.objects, pose.multiply(one.group.matrix));
  const left = drawn.filter((one) => one.side === "mbs")
    .map((one) => ({one, own: measured(one, matrix())}));
  const isLost = (shape) => shape.mesh === null;
  const lostBodies = new Set([{name: null, shapes: data.mbs.base.shapes}, ...data.mbs.bodies]
    .filter((body) => body.shapes.some(isLost)).map((body) => body.name));
  const lostLinks = new Set(data.urdf.links
    .filter((link) => link.visuals.some(isLost)).map((link) => bodyOfLink(link.name)));
  for (const one of drawn.filter((each) => each.side === "urdf")) {
    const body = bodyOfLink(one.owner), pose = now.mbs.bodies.get(body);
    if (!pose) continue;
    const own = measured(one, pose.clone().invert().multiply(now.links.get(one.owner)));
    const match = left.findIndex((other) => other.one.owner === body && alike(own, other.own));
    if (match >= 0) {
      const [{one: twin}] = left.splice(match, 1);
      now.shapes++;
      one.twin = twin;
      if (one.color && twin.color && one.color.some((c, k) => Math.abs(c - twin.color[k]) > 0.004)) {
        one.differs = twin.differs = "in colour";
      }
    } else if (!lostBodies.has(body)) {
      one.differs = "in form or place";
    }
  }
  for (const {one} of left) if (!lostLinks.has(one.owner)) one.differs = "in form or place";
}

export function differs(one) {
  if (one.differs === "in form or place") return true;
  const links = one.side === "urdf" ? [one.owner] : linksOf.get(one.owner) || [];
  return links.some((link) => now.differing.has(link));
}
