// The shapes of the .mbs, and the visuals and collision shapes of the URDF.

import {data, findBodyOfLink, matrix, poseOf, translation} from "./basics.js";
import {getMeshParts, solids} from "./geometry.js";
import {computeOrigin} from "./kinematics.js";
import {addOfKind, getGroup, setPose} from "./scene.js";

// All shapes that are drawn: {side, owner (a body or a link), label, group, meshes, color,
// difference ("", "in form or place" or "in colour"), counterpart (of a visual), isStandIn}.
export const drawnShapes = [];
// The names of the meshes that cannot be drawn.
export const missingMeshes = [];

export const findBodyOfShape = (shape) =>
  shape.side === "mbs" ? shape.owner : findBodyOfLink(shape.owner);

const STAND_IN_COLOR = [0.62, 0.66, 0.72];
const COLLISION_COLOR = [0.95, 0.5, 0.1], COLLISION_OPACITY = 0.4;
const Y_ONTO_Z = matrix().makeRotationX(Math.PI / 2);

export function drawShapes() {
  for (const body of [{name: null, shapes: data.mbs.base.shapes}, ...data.mbs.bodies]) {
    for (const shape of body.shapes) drawMbsShape(body.name, shape);
  }
  for (const link of data.urdf.links) {
    for (const visual of link.visuals) drawVisual(link.name, visual);
    for (const collision of link.collisions) drawCollision(link.name, collision);
  }
}

// Draw the collision shapes of links whose visuals have no mesh.
export function drawStandIns() {
  for (const standIn of data.standIns) {
    const {pose, meshes} = makeUrdfShape(standIn, STAND_IN_COLOR, 1);
    if (meshes === null) continue;
    const description = {side: "mbs", owner: standIn.body, label: standIn.link, isStandIn: true};
    const bodyPose = poseOf(standIn.pose.slice(0, 9), standIn.pose.slice(9)).multiply(pose);
    addShape({...description, meshes, color: null}, bodyPose);
  }
}

export function makeMaterial(rgb, opacity, side, options = {}) {
  return new THREE.MeshPhongMaterial({
    color: new THREE.Color(...rgb), specular: 0x222222, shininess: 25,
    transparent: opacity < 1, opacity, depthWrite: opacity > 0.5,
    // Equal shapes of both sides are in the same place: that of the .mbs is drawn in front.
    polygonOffset: true, polygonOffsetFactor: side === "urdf" ? 1 : 0,
    polygonOffsetUnits: side === "urdf" ? 2 : 0, ...options,
  });
}

// The objects of a mesh; a part without a colour or an opacity takes that of its shape.
function makeMeshObjects(number, rgb, opacity, side) {
  return getMeshParts(number).map(({geometry, map, vertexColors, color, opacity: partOpacity}) => {
    const partColor = map || vertexColors ? [1, 1, 1] : color || rgb;
    const options = {side: THREE.DoubleSide, map, vertexColors};
    const material = makeMaterial(partColor, partOpacity === null ? opacity : partOpacity, side, options);
    return new THREE.Mesh(geometry, material);
  });
}

// Group the objects of a shape, which belongs to a body or a link.
function addShapeGroup(kind, side, owner, pose, meshes) {
  const group = setPose(new THREE.Group(), pose);
  group.add(...meshes);
  return addOfKind(kind, getGroup(side, owner), group);
}

// Add a shape that is compared with those of the other side: {side, owner, label, meshes, color}.
function addShape(shape, pose) {
  const group = addShapeGroup("shapes", shape.side, shape.owner, pose, shape.meshes);
  const drawnShape = {...shape, group, difference: "", counterpart: null};
  drawnShapes.push(drawnShape);
  for (const object of shape.meshes) object.userData.shape = drawnShape;
}

// Draw a small frame in place of a mesh that cannot be drawn.
function drawMissing(side, owner, name, pose) {
  missingMeshes.push(name);
  addOfKind("shapes", getGroup(side, owner), setPose(new THREE.AxesHelper(data.frame * 0.7), pose));
}

function drawMbsShape(owner, shape) {
  const [alpha, beta, gamma] = shape.rotation;
  const pose = translation(shape.position).multiply(matrix().makeRotationX(alpha))
    .multiply(matrix().makeRotationY(beta)).multiply(matrix().makeRotationZ(gamma))
    .multiply(matrix().makeScale(...shape.scale));
  const rgb = shape.color.map((value) => value / 255), opacity = 1 - shape.transparency;
  const description = {side: "mbs", owner, label: shape.name};
  if (shape.kind === "inline") {
    if (shape.mesh === null) return drawMissing("mbs", owner, shape.url, pose);
    const meshes = makeMeshObjects(shape.mesh, rgb, opacity, "mbs");
    return addShape({...description, meshes, color: null}, pose);
  }
  const geometry = shape.kind === "box" ? solids.box(shape.size)
    : solids[shape.kind](shape.radius, shape.height);
  const meshes = [new THREE.Mesh(geometry, makeMaterial(rgb, opacity, "mbs"))];
  addShape({...description, meshes, color: [...rgb, opacity]}, pose);
}

function drawVisual(link, visual) {
  const [r, g, b, opacity] = visual.color || [0.5, 0.5, 0.5, 1], {type, filename} = visual.geometry;
  const {pose, meshes} = makeUrdfShape(visual, [r, g, b], opacity);
  if (meshes === null) {
    drawMissing("urdf", link, filename, computeOrigin(visual.xyz, visual.rpy));
  } else {
    const color = type === "mesh" ? null : visual.color;
    addShape({side: "urdf", owner: link, label: link, meshes, color}, pose);
  }
}

function drawCollision(link, collision) {
  const {pose, meshes} = makeUrdfShape(collision, COLLISION_COLOR, COLLISION_OPACITY);
  if (meshes === null) return;
  // The colours of a mesh are not shown.
  for (const object of meshes) {
    const options = {side: object.material.side};
    object.material = makeMaterial(COLLISION_COLOR, COLLISION_OPACITY, "urdf", options);
  }
  addShapeGroup("collisions", "urdf", link, pose, meshes);
}

// The pose and the objects of a visual or a collision shape; null if its mesh is missing.
function makeUrdfShape({xyz, rpy, geometry, mesh}, rgb, opacity) {
  const pose = computeOrigin(xyz, rpy);
  if (geometry.type === "mesh") {
    pose.multiply(matrix().makeScale(...geometry.scale));
    return {pose, meshes: mesh === null ? null : makeMeshObjects(mesh, rgb, opacity, "urdf")};
  }
  const makeObject = (solid) => new THREE.Mesh(solid, makeMaterial(rgb, opacity, "urdf"));
  if (geometry.type === "box") return {pose, meshes: [makeObject(solids.box(geometry.size))]};
  const {type, radius, length} = geometry;
  // The cylinders of three.js are along y, those of a URDF along z.
  if (type === "cylinder" || type === "capsule") pose.multiply(Y_ONTO_Z);
  if (type !== "capsule") return {pose, meshes: [makeObject(solids[type](radius, length))]};
  const ends = [-1, 1].map((sign) => {
    const ball = makeObject(solids.sphere(radius));
    ball.position.y = sign * length / 2;
    return ball;
  });
  return {pose, meshes: [makeObject(solids.cylinder(radius, length)), ...ends]};
}
