// What stands beside shapes: skeletons, frames, centres of mass, inertia boxes, sensors, contacts,
// forces, loops and stops.

import {bodyOfJoint, byId, data, matrix, size, vector} from "./basics.js";
import {primitive} from "./geometry.js";
import {ELEMENTARY} from "./kinematics.js";
import {q} from "./positions.js";
import {holder, keep, kinds, place, scene, sides} from "./scene.js";
import {material} from "./shapes.js";

// the skeletons: the side and the object of each bone and knob
export const bones = [];
const BONE = {mbs: [0.93, 0.55, 0.12], urdf: [0.35, 0.5, 0.75]};

function bone(side, owner, to) {
  const end = vector(...to), length = end.length();
  if (length < 1e-9) return;
  const rod = new THREE.Mesh(primitive.cylinder(size * 0.0055, length), material(BONE[side], 1, side));
  rod.position.copy(end).multiplyScalar(0.5);
  rod.quaternion.setFromUnitVectors(vector(0, 1, 0), end.clone().divideScalar(length));
  bones.push([side, keep("skeleton", holder(side, owner), rod)]);
}

function knob(side, owner) {
  const ball = new THREE.Mesh(primitive.ball(size * 0.009), material(BONE[side], 1, side));
  bones.push([side, keep("skeleton", holder(side, owner), ball)]);
}

// a frame that is seen through all that is before it
function axes(kind, side, owner, scale, order) {
  const frame = new THREE.AxesHelper(scale);
  frame.material.depthTest = false;
  frame.material.transparent = true;
  frame.renderOrder = order;
  if (side === "urdf") frame.material.opacity = 0.45;
  return keep(kind, holder(side, owner), frame);
}

function centreOfMass(body, heaviest) {
  const radius = size * 0.028 * Math.cbrt(body.mass / heaviest) + size * 0.003;
  const ball = new THREE.Mesh(primitive.sphere(radius), new THREE.MeshPhongMaterial(
    {color: 0x7a1fa2, transparent: true, opacity: 0.75, depthTest: false}));
  ball.position.set(...(body.com || [0, 0, 0]));
  ball.renderOrder = 4;
  keep("coms", holder("mbs", body.name), ball);
}

// the box of even density that has a body's mass and inertia, turned as its principal axes are
function inertiaBox(body) {
  const [xx, xy, xz, yy, yz, zz] = body.inertia;
  const [moments, axes] = principal([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
  const half = (moments[0] + moments[1] + moments[2]) / 2;
  const edges = moments.map((moment) => Math.sqrt(Math.max(12 * (half - moment) / body.mass, 0)));
  const box = new THREE.Mesh(primitive.box(edges.map((edge) => Math.max(edge, 2e-3 * size))),
    new THREE.MeshPhongMaterial({color: 0x18a058, transparent: true, opacity: 0.4, depthWrite: false}));
  place(box, matrix().makeBasis(...axes).setPosition(...(body.com || [0, 0, 0])));
  keep("inertias", holder("mbs", body.name), box);
}

// Jacobi's rotations: the principal moments of a symmetric matrix, and its axes
function principal(a) {
  const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 30; sweep++) {
    for (const [i, j] of [[0, 1], [0, 2], [1, 2]]) {
      if (a[i][j] === 0) continue;
      const angle = Math.atan2(2 * a[i][j], a[j][j] - a[i][i]) / 2;
      const c = Math.cos(angle), s = Math.sin(angle);
      for (const row of [...a, ...v]) [row[i], row[j]] = [c * row[i] - s * row[j], s * row[i] + c * row[j]];
      for (let k = 0; k < 3; k++) [a[i][k], a[j][k]] = [c * a[i][k] - s * a[j][k], s * a[i][k] + c * a[j][k]];
      a[i][j] = a[j][i] = 0;
    }
  }
  const [x, y] = [0, 1].map((k) => vector(v[0][k], v[1][k], v[2][k]));
  return [[a[0][0], a[1][1], a[2][2]], [x, y, x.clone().cross(y)]];
}

// these marks are seen through all that is before them
export const MARK = {sensors: 0x0097a7, contacts: 0xd84315, forces: 0xad1457, loops: 0x2e7d32,
  stops: 0x1565c0};
const seen = (kind, Material = THREE.MeshBasicMaterial) => new Material(
  {color: MARK[kind], transparent: true, opacity: 0.85, depthTest: false});

function dot(kind, body, xyz) {
  const ball = new THREE.Mesh(primitive.ball(size * 0.007), seen(kind));
  ball.position.set(...xyz);
  ball.renderOrder = 6;
  keep(kind, holder("mbs", body), ball);
}

export const rowMajor = ([a, b, c, d, e, f, g, h, i], [x, y, z]) =>
  matrix().set(a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1);

function mark([body, xyz, kind, turned]) {
  dot(kind, body, xyz);
  if (turned) place(axes(kind, "mbs", body, data.frame, 6), rowMajor(turned, xyz));
}

// a cut or a link: a line from one end to the other, wherever these are
export const lines = [];
function connect([kind, one, two]) {
  for (const [body, xyz] of [one, two]) dot("loops", body, xyz);
  const line = new THREE.Line(new THREE.BufferGeometry(), seen("loops", THREE.LineBasicMaterial));
  line.renderOrder = 6;
  line.frustumCulled = false;
  lines.push([keep("loops", sides.mbs, line), one, two]);
}

// a joint's way from limit to limit, where it starts from zero, and a hand where the joint is
export const stops = [];
function ring(...form) {
  const flat = new THREE.Mesh(new THREE.RingGeometry(...form), seen("stops"));
  flat.material.side = THREE.DoubleSide;
  return flat;
}
function stop([name, [low, high]]) {
  const joint = bodyOfJoint.get(name)[1], axis = +joint.type[1] - 1, radius = size * 0.05;
  const along = (n) => vector().setComponent(n % 3, 1);
  const across = matrix().makeBasis(along(axis + 1), along(axis + 2), along(axis));
  const line = (points) => new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
    seen("stops", THREE.LineBasicMaterial));
  const group = new THREE.Group(), hand = new THREE.Group();
  if (joint.type[0] === "R") {
    const from = low === null ? -Math.PI : low, to = high === null ? Math.PI : high;
    const way = ring(radius * 0.55, radius, 40, 1, from, Math.min(to - from, 2 * Math.PI));
    way.material.opacity = 0.45;
    group.add(place(way, across));
    hand.add(line([vector(), along(axis + 1).multiplyScalar(radius * 1.2)]));
  } else {
    const from = low === null ? -radius : low, to = high === null ? radius : high;
    group.add(line([from, to].map((end) => along(axis).multiplyScalar(end))));
    for (const end of [low, high]) {
      if (end === null) continue;
      group.add(place(ring(0, radius * 0.4, 20),
        across.clone().setPosition(along(axis).multiplyScalar(end))));
    }
    hand.add(new THREE.Mesh(primitive.ball(radius * 0.15), seen("stops")));
  }
  group.matrixAutoUpdate = hand.matrixAutoUpdate = false;
  group.add(hand);
  group.traverse((part) => { part.renderOrder = 7; });
  stops.push({joint, low, high, group: keep("stops", sides.mbs, group), hand});
}

export function beyond({joint, low, high}) {
  const value = q.get(joint.name);
  return low !== null && value < low - 1e-9 || high !== null && value > high + 1e-9;
}

export function moveMarks({bodies, joints}) {
  const at = ([body, xyz]) => vector(...xyz).applyMatrix4(bodies.get(body));
  for (const [line, one, two] of lines) line.geometry.setFromPoints([at(one), at(two)]);
  for (const one of stops) {
    const moved = ELEMENTARY[one.joint.type](q.get(one.joint.name));
    one.group.matrix.copy(joints.get(one.joint.name)).multiply(moved.clone().invert());
    one.hand.matrix.copy(moved);
    one.group.traverse(({material: m}) => m && m.color.set(beyond(one) ? 0xd6273b : MARK.stops));
  }
}

export function drawMarks() {
  const heaviest = Math.max(1e-9, ...data.mbs.bodies.map((body) => body.mass || 0));
  const ends = data.marks.lines.flatMap(([, ...two]) => two);
  const held = new Set([...data.mbs.bodies.map((body) => body.parent), ...ends.map(([body]) => body)]);
  axes("frames", "mbs", null, data.frame, 5);
  for (const body of data.mbs.bodies) {
    axes("frames", "mbs", body.name, data.frame, 5);
    knob("mbs", body.name);
    bone("mbs", body.parent, body.at);
    if (!held.has(body.name)) bone("mbs", body.name, body.com || [0, 0, 0]);
    if (body.mass) centreOfMass(body, heaviest);
    if (body.mass && body.inertia) inertiaBox(body);
  }
  for (const link of data.urdf.links) {
    axes("frames", "urdf", link.name, data.frame * 1.3, 5);
    knob("urdf", link.name);
  }
  for (const joint of data.urdf.joints) bone("urdf", joint.parent, joint.xyz);
  for (const [body, xyz] of ends) bone("mbs", body, xyz);
  data.marks.points.forEach(mark);
  data.marks.lines.forEach(connect);
  data.marks.stops.filter(([name]) => q.has(name)).forEach(stop);
  for (const kind of Object.keys(MARK)) byId(`show-${kind}`).parentNode.hidden = !kinds[kind].length;
}

// arrows of forces, each at a point of a body, in the axes of the base
export function makeArrows(pushed) {
  const arrows = pushed.map((isPush) => {
    const arrow = new THREE.ArrowHelper(vector(0, 0, 1), vector(), 1, isPush ? MARK.stops : MARK.forces);
    arrow.visible = false;
    for (const part of isPush ? [arrow.line, arrow.cone] : []) {
      part.material.depthTest = false;  // it begins inside the body
      part.renderOrder = 9;
    }
    scene.add(arrow);
    return arrow;
  });
  // the longest force, `most` (N), is drawn as half the robot
  return (k, pose, at, force, most) => {
    const arrow = arrows[k], length = force.length() / most * size / 2;
    arrow.visible = length > 0.002 * size && byId("show-forces").checked;
    if (!arrow.visible) return;
    arrow.position.copy(at).applyMatrix4(pose);
    arrow.setDirection(force.clone().normalize());
    arrow.setLength(length, Math.min(size / 20, length / 2), size / 40);
  };
}
