// The shapes of the .mbs, and the visuals and collision shapes of the URDF.

import {data, matrix, shift} from "./basics.js";
import {meshParts, primitive} from "./geometry.js";
import {origin} from "./kinematics.js";
import {holder, keep, place} from "./scene.js";

// each drawn shape: its side, its owner (a body or a link), its group and its objects
export const drawn = [];
// the meshes that are not there
export const missing = [];

const COLLISION = [0.95, 0.5, 0.1];
const Y_ONTO_Z = matrix().makeRotationX(Math.PI / 2);

export function material(rgb, opacity, side, extra = {}) {
  return new THREE.MeshPhongMaterial({
    color: new THREE.Color(...rgb), specular: 0x222222, shininess: 25,
    transparent: opacity < 1, opacity, depthWrite: opacity > 0.5,
    // what is the same on both sides lies in the same place: the .mbs is seen
    polygonOffset: true, polygonOffsetFactor: side === "urdf" ? 1 : 0,
    polygonOffsetUnits: side === "urdf" ? 2 : 0, ...extra,
  });
}

function meshObjects(number, rgb, opacity, side) {
  return meshParts(number).map(({geometry, map, vertexColors, color, opacity: own}) => {
    const painted = map || vertexColors ? [1, 1, 1] : color || rgb;
    const extra = {side: THREE.DoubleSide, map, vertexColors};
    return new THREE.Mesh(geometry, material(painted, own === null ? opacity : own, side, extra));
  });
}

// group the objects of a shape; it belongs to a body or a link
function add(kind, side, owner, pose, objects) {
  const group = place(new THREE.Group(), pose);
  group.add(...objects);
  return keep(kind, holder(side, owner), group);
}

function draw(side, owner, about, pose, objects, color) {
  const one = {side, owner, about, objects, color, differs: "",
    group: add("shapes", side, owner, pose, objects)};
  drawn.push(one);
  for (const object of objects) object.userData.drawn = one;
}

// a small frame stands for a mesh that cannot be drawn
function drawMissing(side, owner, name, pose) {
  missing.push(name);
  keep("shapes", holder(side, owner), place(new THREE.AxesHelper(data.frame * 0.7), pose));
}

function mbsShape(owner, shape) {
  const [alpha, beta, gamma] = shape.rotation;
  const pose = shift(shape.position).multiply(matrix().makeRotationX(alpha))
    .multiply(matrix().makeRotationY(beta)).multiply(matrix().makeRotationZ(gamma))
    .multiply(matrix().makeScale(...shape.scale));
  const rgb = shape.color.map((c) => c / 255), opacity = 1 - shape.transparency;
  if (shape.kind === "inline") {
    if (shape.mesh === null) return drawMissing("mbs", owner, shape.url, pose);
    return draw("mbs", owner, shape.name, pose, meshObjects(shape.mesh, rgb, opacity, "mbs"), null);
  }
  const geometry = shape.kind === "box" ? primitive.box(shape.size)
    : primitive[shape.kind](shape.radius, shape.height);
  const objects = [new THREE.Mesh(geometry, material(rgb, opacity, "mbs"))];
  draw("mbs", owner, shape.name, pose, objects, [...rgb, opacity]);
}

// the pose and the objects of a visual or a collision shape; no objects if its mesh is missing
function urdfShape(given, rgb, opacity) {
  const pose = origin(given.xyz, given.rpy), shape = given.geometry;
  if (shape.type === "mesh") {
    pose.multiply(matrix().makeScale(...shape.scale));
    return [pose, given.mesh === null ? null : meshObjects(given.mesh, rgb, opacity, "urdf")];
  }
  if (shape.type === "cylinder" || shape.type === "capsule") pose.multiply(Y_ONTO_Z);
  const paint = (geometry) => new THREE.Mesh(geometry, material(rgb, opacity, "urdf"));
  if (shape.type === "capsule") {
    const ends = [-1, 1].map((side) => {
      const ball = paint(primitive.sphere(shape.radius));
      ball.position.y = side * shape.length / 2;
      return ball;
    });
    return [pose, [paint(primitive.cylinder(shape.radius, shape.length)), ...ends]];
  }
  return [pose, [paint(shape.type === "box" ? primitive.box(shape.size)
    : primitive[shape.type](shape.radius, shape.length))]];
}

function visual(link, given) {
  const [r, g, b, a] = given.color || [0.5, 0.5, 0.5, 1], shape = given.geometry;
  const [pose, objects] = urdfShape(given, [r, g, b], a);
  if (objects === null) drawMissing("urdf", link, shape.filename, origin(given.xyz, given.rpy));
  else draw("urdf", link, link, pose, objects, shape.type === "mesh" ? null : given.color);
}

function collision(link, given) {
  const [pose, objects] = urdfShape(given, COLLISION, 0.4);
  if (objects === null) return;
  // in one colour, whatever the mesh says
  for (const object of objects) object.material = material(COLLISION, 0.4, "urdf", {side: object.material.side});
  add("collisions", "urdf", link, pose, objects);
}

export function drawShapes() {
  for (const body of [{name: null, shapes: data.mbs.base.shapes}, ...data.mbs.bodies]) {
    for (const shape of body.shapes) mbsShape(body.name, shape);
  }
  for (const link of data.urdf.links) {
    for (const given of link.visuals) visual(link.name, given);
    for (const given of link.collisions) collision(link.name, given);
  }
}
