"use strict";
(() => {
const data = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);
const element = (tag, kind, text) => {
  const made = document.createElement(tag);
  if (kind) made.className = kind;
  if (text !== undefined) made.textContent = text;
  return made;
};
const matrix = () => new THREE.Matrix4();
// a page of an .mbs alone has no URDF side
const alone = data.urdf.root === null;

// --- the .mbs: elementary joints, each in the current frame, in the order of the file ---------

const ELEMENTARY = {
  T1: (q) => matrix().makeTranslation(q, 0, 0),
  T2: (q) => matrix().makeTranslation(0, q, 0),
  T3: (q) => matrix().makeTranslation(0, 0, q),
  R1: (q) => matrix().makeRotationX(q),
  R2: (q) => matrix().makeRotationY(q),
  R3: (q) => matrix().makeRotationZ(q),
};

function mbsPoses(q) {
  const bodies = new Map([[null, matrix()]]), joints = new Map();
  for (const body of data.mbs.bodies) {
    const pose = bodies.get(body.parent).clone().multiply(matrix().makeTranslation(...body.at));
    for (const joint of body.joints) {
      const value = q.has(joint.name) ? q.get(joint.name) : joint.q || 0;
      pose.multiply(ELEMENTARY[joint.type](value));
      joints.set(joint.name, pose.clone());
    }
    bodies.set(body.name, pose);
  }
  return {bodies, joints};
}

// --- the URDF: Rodrigues' formula about the joint's axis --------------------------------------

function rodrigues([x, y, z], angle) {
  const s = Math.sin(angle), c = 1 - Math.cos(angle);
  return matrix().set(
    1 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y, 0,
    c * x * y + s * z, 1 - c * (x * x + z * z), c * y * z - s * x, 0,
    c * x * z - s * y, c * y * z + s * x, 1 - c * (x * x + y * y), 0,
    0, 0, 0, 1);
}
const shift = ([x, y, z], by = 1) => matrix().makeTranslation(x * by, y * by, z * by);
const X = [1, 0, 0], Y = [0, 1, 0], Z = [0, 0, 1];

// fixed-frame roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll)
const origin = (xyz, [roll, pitch, yaw]) => shift(xyz)
  .multiply(rodrigues(Z, yaw)).multiply(rodrigues(Y, pitch)).multiply(rodrigues(X, roll));

function unit(axis) {
  const largest = Math.max(...axis.map(Math.abs));
  const scaled = axis.map((c) => c / largest);
  const length = Math.hypot(...scaled);
  return scaled.map((c) => c / length);
}

// the two directions in which a planar joint shifts, which URDF leaves open
function inPlane([x, y, z]) {
  const tiny = 1e-9;
  let u;
  if (Math.abs(x) <= tiny && Math.abs(y) > tiny) u = [0, -z, y];
  else if (Math.abs(y) <= tiny && Math.abs(z) > tiny) u = [z, 0, -x];
  else u = [-y / Math.hypot(x, y), x / Math.hypot(x, y), 0];
  return [u, [y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0]]];
}

const coordinates = new Map(data.coordinates);

function motion(joint, values) {
  if (joint.type === "floating") {
    const [a, b, c, r1, r2, r3] = values;
    return shift([a, b, c])
      .multiply(rodrigues(X, r1)).multiply(rodrigues(Y, r2)).multiply(rodrigues(Z, r3));
  }
  const axis = unit(joint.axis);
  if (joint.type === "planar") {
    const [u, v] = inPlane(axis);
    return shift(u, values[0]).multiply(shift(v, values[1])).multiply(rodrigues(axis, values[2]));
  }
  return joint.type === "prismatic" ? shift(axis, values[0]) : rodrigues(axis, values[0]);
}

function urdfPoses(q) {
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

// --- the positions, their limits, and which follow which --------------------------------------

const q = new Map(), sliders = new Map(), limits = new Map(), follows = new Map();
const size = data.size;
const moving = [], numbers = new Map();
let count = 0;
for (const body of data.mbs.bodies) {
  for (const joint of body.joints) {
    numbers.set(joint.name, ++count);
    if (alone || joint.nature !== "driven") moving.push(joint);
  }
}
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
const clamp = (name, value) => {
  const [low, high] = limits.get(name);
  return Math.min(Math.max(value, low), high);
};
for (const joint of moving) q.set(joint.name, clamp(joint.name, joint.q || 0));

function set(name, value) {
  q.set(name, clamp(name, Number.isFinite(value) ? value : 0));
}

function settle() {
  if (byId("mimic").checked) {
    for (let round = 0; round < follows.size; round++) {
      let changed = false;
      for (const [name, [leader, factor, offset]] of follows) {
        const value = factor * q.get(leader) + offset;
        changed = changed || value !== q.get(name);
        q.set(name, value);
      }
      if (!changed) break;
    }
  }
  for (const [name, show] of sliders) show(q.get(name));
  update();
}

// --- meshes: arrays unpacked, normals smoothed where faces meet at less than 0.5 rad ----------

async function unpack() {
  const text = atob(byId("arrays").textContent.trim());
  const packed = Uint8Array.from(text, (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  return ([at, length, differences]) => {
    const out = new Uint32Array(length), plane = (k) => at + k * length;
    const [a, b, c, d] = [plane(0), plane(1), plane(2), plane(3)];
    let sum = 0;
    for (let i = 0; i < length; i++) {
      const word = bytes[a + i] | bytes[b + i] << 8 | bytes[c + i] << 16 | bytes[d + i] << 24;
      out[i] = differences ? sum = sum + (word >>> 1 ^ -(word & 1)) | 0 : word;
    }
    return out;
  };
}

const CREASE = Math.cos(0.5);

function meshGeometry(part, array) {
  const points = new Float32Array(array(part.points).buffer), index = array(part.triangles);
  const position = new Float32Array(3 * index.length);
  for (let i = 0; i < index.length; i++) {
    for (let k = 0; k < 3; k++) position[3 * i + k] = points[3 * index[i] + k];
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(creased(position, index), 3));
  if (part.uv) {
    geometry.setAttribute("uv",
      new THREE.BufferAttribute(new Float32Array(array(part.uv).buffer), 2));
  }
  if (part.colors) {
    const packed = array(part.colors), rgb = new Uint8Array(3 * packed.length);
    packed.forEach((word, i) => rgb.set([word >> 16 & 255, word >> 8 & 255, word & 255], 3 * i));
    geometry.setAttribute("color", new THREE.BufferAttribute(rgb, 3, true));
  }
  return geometry;
}

function creased(position, index) {
  const faces = index.length / 3, flat = new Float32Array(3 * faces);
  const about = new Uint32Array(Math.max(0, ...chunked(index, Math.max)) + 2);
  for (let f = 0; f < faces; f++) {
    const p = 9 * f;
    const ax = position[p + 3] - position[p], ay = position[p + 4] - position[p + 1];
    const az = position[p + 5] - position[p + 2], bx = position[p + 6] - position[p];
    const by = position[p + 7] - position[p + 1], bz = position[p + 8] - position[p + 2];
    const n = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
    const length = Math.hypot(...n) || 1;
    for (let k = 0; k < 3; k++) flat[3 * f + k] = n[k] / length;
  }
  for (const i of index) about[i + 1]++;
  for (let i = 1; i < about.length; i++) about[i] += about[i - 1];
  const place = about.slice(), around = new Uint32Array(index.length);
  index.forEach((point, corner) => { around[place[point]++] = Math.floor(corner / 3); });
  const normals = new Float32Array(3 * index.length);
  for (let corner = 0; corner < index.length; corner++) {
    const own = 3 * Math.floor(corner / 3);
    const nx = flat[own], ny = flat[own + 1], nz = flat[own + 2];
    let x = 0, y = 0, z = 0;
    for (let i = about[index[corner]]; i < about[index[corner] + 1]; i++) {
      const f = 3 * around[i];
      if (flat[f] * nx + flat[f + 1] * ny + flat[f + 2] * nz >= CREASE) {
        x += flat[f]; y += flat[f + 1]; z += flat[f + 2];
      }
    }
    const length = Math.hypot(x, y, z) || 1;
    normals[3 * corner] = x / length;
    normals[3 * corner + 1] = y / length;
    normals[3 * corner + 2] = z / length;
  }
  return normals;
}

function* chunked(values, reduce) {
  for (let i = 0; i < values.length; i += 5000) yield reduce(...values.subarray(i, i + 5000));
}

// area, centroid and second moments of the surface: equal for equal shapes, however cut up
function surface(position, transform) {
  let area = 0;
  const first = [0, 0, 0], second = [0, 0, 0, 0, 0, 0];
  const v = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  const e = new THREE.Vector3(), g = new THREE.Vector3();
  for (let i = 0; i + 2 < position.count; i += 3) {
    for (let k = 0; k < 3; k++) v[k].fromBufferAttribute(position, i + k).applyMatrix4(transform);
    const a = e.subVectors(v[1], v[0]).cross(g.subVectors(v[2], v[0])).length() / 2;
    area += a;
    const sum = v.reduce((s, p) => [s[0] + p.x, s[1] + p.y, s[2] + p.z], [0, 0, 0]);
    for (let k = 0; k < 3; k++) first[k] += a * sum[k] / 3;
    for (const [n, [r, c]] of [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]].entries()) {
      const products = v.reduce((s, p) => s + p.getComponent(r) * p.getComponent(c), 0);
      second[n] += a * (products + sum[r] * sum[c]) / 12;
    }
  }
  const centre = first.map((c) => c / (area || 1));
  const pairs = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];
  const moments = second.map((m, n) => m / (area || 1) - centre[pairs[n][0]] * centre[pairs[n][1]]);
  return {area, centre, moments};
}

function alike(a, b) {
  const extent = Math.sqrt(Math.abs(a.moments[0] + a.moments[3] + a.moments[5])) || 1e-6;
  const tolerance = 1e-3 * extent + 1e-6 * size;
  return Math.abs(a.area - b.area) <= 2e-3 * Math.max(a.area, b.area)
    && a.centre.every((c, k) => Math.abs(c - b.centre[k]) <= tolerance)
    && a.moments.every((m, k) => Math.abs(m - b.moments[k]) <= 4 * tolerance * extent);
}

// --- the scene ---------------------------------------------------------------------------------

const view = byId("view");
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(38, 1, size / 200, size * 200);
camera.up.set(0, 0, 1);
let renderer = null;
try {
  // the last picture is kept, so that the page can be printed
  renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
} catch (error) {
  view.append(element("div", "nogl",
    "This browser has no WebGL, so the 3D model cannot be drawn; all else on the page works."));
}
scene.add(new THREE.HemisphereLight(0xffffff, 0x8d96a8, 0.72));
const lamp = new THREE.DirectionalLight(0xffffff, 0.42);
const sun = new THREE.DirectionalLight(0xffffff, 0.22);
sun.position.set(-1, -2, 3);
scene.add(camera, sun);
camera.add(lamp, lamp.target);
lamp.position.set(0.6, 0.8, 1);
lamp.target.position.set(0, 0, -1);

const sides = {mbs: new THREE.Group(), urdf: new THREE.Group()};
scene.add(sides.mbs, sides.urdf);
const holders = {mbs: new Map(), urdf: new Map()};
const bones = [];
const kinds = {shapes: [], skeleton: [], frames: [], coms: [], inertias: [], collisions: [],
  sensors: [], contacts: [], forces: [], loops: [], stops: []};
const drawn = [];

function holder(side, name) {
  const found = holders[side].get(name);
  if (found) return found;
  const group = new THREE.Group();
  group.matrixAutoUpdate = false;
  holders[side].set(name, group);
  sides[side].add(group);
  return group;
}

function place(object, pose) {
  object.matrixAutoUpdate = false;
  object.matrix.copy(pose);
  return object;
}

function material(rgb, opacity, side, extra = {}) {
  return new THREE.MeshPhongMaterial({
    color: new THREE.Color(...rgb), specular: 0x222222, shininess: 25,
    transparent: opacity < 1, opacity, depthWrite: opacity > 0.5,
    // what is the same on both sides lies in the same place: the .mbs is seen
    polygonOffset: true, polygonOffsetFactor: side === "urdf" ? 1 : 0,
    polygonOffsetUnits: side === "urdf" ? 2 : 0, ...extra,
  });
}

const Y_ONTO_Z = matrix().makeRotationX(Math.PI / 2);
const cache = new Map();
const once = (key, make) => cache.get(key) || cache.set(key, make()).get(key);
const plain = (key, make) => once(key, () => make().toNonIndexed());
const primitive = {
  box: ([x, y, z]) => plain(`box ${x} ${y} ${z}`, () => new THREE.BoxGeometry(x, y, z)),
  sphere: (r) => plain(`sphere ${r}`, () => new THREE.SphereGeometry(r, 40, 24)),
  ball: (r) => plain(`ball ${r}`, () => new THREE.SphereGeometry(r, 12, 8)),  // a mark: there are many
  cylinder: (r, h) => plain(`cylinder ${r} ${h}`, () => new THREE.CylinderGeometry(r, r, h, 40)),
  cone: (r, h) => plain(`cone ${r} ${h}`, () => new THREE.ConeGeometry(r, h, 40)),
};

let array = null, textures = [], built = [];
function meshParts(number, rgb, opacity, side) {
  return data.meshes[number].map((part, nth) => {
    const geometry = once(`mesh ${JSON.stringify([part.points, part.triangles, part.uv, part.colors])}`,
      () => meshGeometry(part, array));
    const clear = part.transparency === null ? 1 - opacity : part.transparency;
    const extra = {side: THREE.DoubleSide};
    if (part.texture !== undefined) extra.map = textures[part.texture];
    if (part.colors) extra.vertexColors = true;
    const own = part.texture !== undefined || part.colors ? [1, 1, 1] : part.color || rgb;
    return new THREE.Mesh(geometry, material(own, 1 - clear, side, extra));
  });
}

function draw(side, owner, about, pose, objects, color) {
  const group = place(new THREE.Group(), pose);
  group.add(...objects);
  holder(side, owner).add(group);
  kinds.shapes.push(group);
  drawn.push({side, owner, about, group, objects, color, differs: ""});
  for (const object of objects) object.userData.drawn = drawn[drawn.length - 1];
}

const missing = [];
function lost(side, owner, name, pose) {
  missing.push(name);
  const axes = new THREE.AxesHelper(data.frame * 0.7);
  holder(side, owner).add(place(axes, pose));
  kinds.shapes.push(axes);
}

function mbsShape(owner, shape) {
  const [alpha, beta, gamma] = shape.rotation;
  const pose = shift(shape.position).multiply(matrix().makeRotationX(alpha))
    .multiply(matrix().makeRotationY(beta)).multiply(matrix().makeRotationZ(gamma))
    .multiply(matrix().makeScale(...shape.scale));
  const rgb = shape.color.map((c) => c / 255), opacity = 1 - shape.transparency;
  let objects, color = null;
  if (shape.kind === "inline") {
    if (shape.mesh === null) return lost("mbs", owner, shape.url, pose);
    objects = meshParts(shape.mesh, rgb, opacity, "mbs");
  } else {
    const geometry = shape.kind === "box" ? primitive.box(shape.size)
      : shape.kind === "sphere" ? primitive.sphere(shape.radius)
      : primitive[shape.kind](shape.radius, shape.height);
    objects = [new THREE.Mesh(geometry, material(rgb, opacity, "mbs"))];
    color = [...rgb, opacity];
  }
  draw("mbs", owner, shape.name, pose, objects, color);
}

function collision(link, given) {
  const pose = origin(given.xyz, given.rpy), shape = given.geometry;
  let objects;
  if (shape.type === "mesh") {
    if (given.mesh === null) return;
    pose.multiply(matrix().makeScale(...shape.scale));
    objects = meshParts(given.mesh, COLLISION, 0.4, "urdf");
  } else {
    if (shape.type === "cylinder") pose.multiply(Y_ONTO_Z);
    objects = [new THREE.Mesh(simple(shape), material(COLLISION, 0.4, "urdf"))];
  }
  for (const object of objects) {
    object.material.color.setRGB(...COLLISION);
    object.material.map = null;
    object.material.vertexColors = false;
    object.material.opacity = 0.4;
    object.material.transparent = true;
    object.material.depthWrite = false;
  }
  const group = place(new THREE.Group(), pose);
  group.add(...objects);
  holder("urdf", link).add(group);
  kinds.collisions.push(group);
}
const COLLISION = [0.95, 0.5, 0.1];
const simple = (shape) => shape.type === "box" ? primitive.box(shape.size)
  : shape.type === "sphere" ? primitive.sphere(shape.radius)
  : primitive.cylinder(shape.radius, shape.length);

// the box of even density that has a body's mass and inertia, turned as its principal axes are
function inertiaBox(body) {
  const [xx, xy, xz, yy, yz, zz] = body.inertia;
  const [moments, turned] = principal([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
  const half = (moments[0] + moments[1] + moments[2]) / 2;
  const sides = moments.map((moment) => Math.sqrt(Math.max(12 * (half - moment) / body.mass, 0)));
  const least = 2e-3 * size;
  const box = new THREE.Mesh(primitive.box(sides.map((side) => Math.max(side, least))),
    new THREE.MeshPhongMaterial({color: 0x18a058, transparent: true, opacity: 0.4, depthWrite: false}));
  const [x, y, z] = body.com || [0, 0, 0];
  place(box, matrix().set(
    ...turned[0], x, ...turned[1], y, ...turned[2], z, 0, 0, 0, 1));
  holder("mbs", body.name).add(box);
  kinds.inertias.push(box);
}

// Jacobi's rotations: the principal moments of a symmetric matrix, and its axes as columns
function principal(m) {
  const a = m.map((row) => [...row]), v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 30; sweep++) {
    for (const [i, j] of [[0, 1], [0, 2], [1, 2]]) {
      if (a[i][j] === 0) continue;
      const angle = Math.atan2(2 * a[i][j], a[j][j] - a[i][i]) / 2;
      const c = Math.cos(angle), s = Math.sin(angle);
      for (const rows of [a, v]) {
        for (const row of rows) [row[i], row[j]] = [c * row[i] - s * row[j], s * row[i] + c * row[j]];
      }
      for (let k = 0; k < 3; k++) [a[i][k], a[j][k]] = [c * a[i][k] - s * a[j][k], s * a[i][k] + c * a[j][k]];
      a[i][j] = a[j][i] = 0;
    }
  }
  const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
  const [x, y] = [0, 1].map((k) => v.map((row) => row[k])), z = cross(x, y);
  return [[0, 1, 2].map((k) => a[k][k]), [0, 1, 2].map((k) => [x[k], y[k], z[k]])];
}

function urdfVisual(link, visual) {
  const pose = origin(visual.xyz, visual.rpy), shape = visual.geometry;
  const [r, g, b, a] = visual.color || [0.5, 0.5, 0.5, 1];
  let objects;
  if (shape.type === "mesh") {
    if (visual.mesh === null) return lost("urdf", link, shape.filename, pose);
    pose.multiply(matrix().makeScale(...shape.scale));
    objects = meshParts(visual.mesh, [r, g, b], a, "urdf");
  } else {
    if (shape.type === "cylinder") pose.multiply(Y_ONTO_Z);
    objects = [new THREE.Mesh(simple(shape), material([r, g, b], a, "urdf"))];
  }
  draw("urdf", link, link, pose, objects, shape.type === "mesh" ? null : visual.color);
}

function bone(side, owner, to, color) {
  const end = new THREE.Vector3(...to), length = end.length();
  if (length < 1e-9) return;
  const thin = size * 0.0055;
  const rod = new THREE.Mesh(primitive.cylinder(thin, length),
    material(color, 1, side));
  rod.position.copy(end).multiplyScalar(0.5);
  rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), end.clone().divideScalar(length));
  holder(side, owner).add(rod);
  kinds.skeleton.push(rod);
  bones.push([side, rod]);
}

function knob(side, owner, color) {
  const ball = new THREE.Mesh(primitive.ball(size * 0.009), material(color, 1, side));
  holder(side, owner).add(ball);
  kinds.skeleton.push(ball);
  bones.push([side, ball]);
}

function axes(side, owner, scale) {
  const frame = new THREE.AxesHelper(scale);
  frame.material.depthTest = false;
  frame.material.transparent = true;
  frame.renderOrder = 5;
  if (side === "urdf") frame.material.opacity = 0.45;
  holder(side, owner).add(frame);
  kinds.frames.push(frame);
}

// sensors, contacts, forces, loops and stops are seen through all that is before them
const MARK = {sensors: 0x0097a7, contacts: 0xd84315, forces: 0xad1457, loops: 0x2e7d32, stops: 0x1565c0};
const seen = (kind, Material = THREE.MeshBasicMaterial) => new Material(
  {color: MARK[kind], transparent: true, opacity: 0.85, depthTest: false});

function dot(kind, parent, [x, y, z]) {
  const ball = new THREE.Mesh(primitive.ball(size * 0.007), seen(kind));
  ball.position.set(x, y, z);
  ball.renderOrder = 6;
  parent.add(ball);
  kinds[kind].push(ball);
}

function mark([body, xyz, kind, turned]) {
  dot(kind, holder("mbs", body), xyz);
  if (!turned) return;
  const frame = new THREE.AxesHelper(data.frame);
  frame.material.depthTest = false;
  frame.renderOrder = 6;
  const [a, b, c, d, e, f, g, h, i] = turned;
  holder("mbs", body).add(place(frame, matrix().set(
    a, b, c, xyz[0], d, e, f, xyz[1], g, h, i, xyz[2], 0, 0, 0, 1)));
  kinds[kind].push(frame);
}

// a cut or a link: a line from one end to the other, wherever these are
const lines = [];
function connect([kind, one, two]) {
  for (const [body, xyz] of [one, two]) dot("loops", holder("mbs", body), xyz);
  const line = new THREE.Line(new THREE.BufferGeometry(), seen("loops", THREE.LineBasicMaterial));
  line.renderOrder = 6;
  line.frustumCulled = false;
  sides.mbs.add(line);
  kinds.loops.push(line);
  lines.push([line, one, two]);
}

// a joint's way from limit to limit, where it starts from zero, and a hand where the joint is
const stops = [];
const ring = (...form) => {
  const flat = new THREE.Mesh(new THREE.RingGeometry(...form), seen("stops"));
  flat.material.side = THREE.DoubleSide;
  return flat;
};
const AXES = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];
function stop([name, [low, high]]) {
  const joint = bodyOfJoint.get(name)[1], [i, j, k] = AXES[+joint.type[1] - 1];
  const along = (n) => new THREE.Vector3().setComponent(n, 1);
  const group = new THREE.Group(), radius = size * 0.05;
  group.matrixAutoUpdate = false;
  const line = (points) => new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
    seen("stops", THREE.LineBasicMaterial));
  const hand = new THREE.Group();
  if (joint.type[0] === "R") {
    const from = low === null ? -Math.PI : low, to = high === null ? Math.PI : high;
    const way = ring(radius * 0.55, radius, 40, 1, from, Math.min(to - from, 2 * Math.PI));
    way.material.opacity = 0.45;
    place(way, matrix().makeBasis(along(i), along(j), along(k)));
    group.add(way);
    hand.add(line([new THREE.Vector3(), along(i).multiplyScalar(radius * 1.2)]));
  } else {
    const from = low === null ? -radius : low, to = high === null ? radius : high;
    group.add(line([along(k).multiplyScalar(from), along(k).multiplyScalar(to)]));
    for (const end of [low, high]) {
      if (end === null) continue;
      const wall = ring(0, radius * 0.4, 20);
      place(wall, matrix().makeBasis(along(i), along(j), along(k))
        .setPosition(along(k).multiplyScalar(end)));
      group.add(wall);
    }
    hand.add(new THREE.Mesh(primitive.ball(radius * 0.15), seen("stops")));
  }
  hand.matrixAutoUpdate = false;
  group.add(hand);
  group.traverse((part) => { part.renderOrder = 7; });
  sides.mbs.add(group);
  kinds.stops.push(group);
  stops.push({joint, low, high, group, hand});
}

const beyond = ({joint, low, high}) => {
  const value = q.get(joint.name);
  return low !== null && value < low - 1e-9 || high !== null && value > high + 1e-9;
};
function moveMarks() {
  const at = ([body, xyz]) => new THREE.Vector3(...xyz).applyMatrix4(poses.mbs.bodies.get(body));
  for (const [line, one, two] of lines) line.geometry.setFromPoints([at(one), at(two)]);
  for (const one of stops) {
    const moved = ELEMENTARY[one.joint.type](q.get(one.joint.name));
    one.group.matrix.copy(poses.mbs.joints.get(one.joint.name)).multiply(moved.clone().invert());
    one.hand.matrix.copy(moved);
    one.group.traverse(({material: m}) => m && m.color.set(beyond(one) ? 0xd6273b : MARK.stops));
  }
}

const BONE = {mbs: [0.93, 0.55, 0.12], urdf: [0.35, 0.5, 0.75]};
const bodyOf = new Map(data.mbs.bodies.map((body) => [body.name, body]));

function build() {
  const heaviest = Math.max(1e-9, ...data.mbs.bodies.map((body) => body.mass || 0));
  for (const shape of data.mbs.base.shapes) mbsShape(null, shape);
  axes("mbs", null, data.frame);
  for (const body of data.mbs.bodies) {
    body.shapes.forEach((shape) => mbsShape(body.name, shape));
    axes("mbs", body.name, data.frame);
    knob("mbs", body.name, BONE.mbs);
    bone("mbs", body.parent, body.at, BONE.mbs);
    if (body.mass) {
      const radius = size * 0.028 * Math.cbrt(body.mass / heaviest) + size * 0.003;
      const ball = new THREE.Mesh(primitive.sphere(radius), new THREE.MeshPhongMaterial(
        {color: 0x7a1fa2, transparent: true, opacity: 0.75, depthTest: false}));
      ball.position.set(...(body.com || [0, 0, 0]));
      ball.renderOrder = 4;
      holder("mbs", body.name).add(ball);
      kinds.coms.push(ball);
      if (body.inertia) inertiaBox(body);
    }
  }
  for (const link of data.urdf.links) {
    link.visuals.forEach((visual) => urdfVisual(link.name, visual));
    link.collisions.forEach((given) => collision(link.name, given));
    axes("urdf", link.name, data.frame * 1.3);
    knob("urdf", link.name, BONE.urdf);
  }
  for (const joint of data.urdf.joints) bone("urdf", joint.parent, joint.xyz, BONE.urdf);
  data.marks.points.forEach(mark);
  data.marks.lines.forEach(connect);
  data.marks.stops.filter(([name]) => q.has(name)).forEach(stop);
  for (const kind of Object.keys(MARK)) byId(`show-${kind}`).parentNode.hidden = !kinds[kind].length;
  compareShapes();
}

// --- the two sides compared --------------------------------------------------------------------

const frames = new Map(data.frames);
let poses = null, differing = new Set(), largest = 0, farthest = 0, compared = 0;

function apart(a, b) {
  let turn = 0, along = 0;
  for (const [k, value] of a.elements.entries()) {
    const off = Math.abs(value - b.elements[k]);
    if (k >= 12) along = Math.max(along, off);
    else turn = Math.max(turn, off);
  }
  return [Math.max(turn, along / size), along];
}

function evaluate() {
  const mbs = mbsPoses(q), links = urdfPoses(q);
  poses = {mbs, links};
  differing = new Set();
  largest = farthest = compared = 0;
  for (const [link, pose] of links) {
    const at = frames.get(link);
    if (!at) continue;
    const held = (at.joint === null ? mbs.bodies.get(at.body) : mbs.joints.get(at.joint))
      .clone().multiply(rowMajor(at.pose));
    const [off, along] = apart(pose, held);
    compared++;
    largest = Math.max(largest, off);
    farthest = Math.max(farthest, along);
    if (!(off <= 1e-6)) differing.add(link);
  }
}

function rowMajor([a, b, c, d, e, f, g, h, i, x, y, z]) {
  return matrix().set(a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1);
}

function measured(one, pose) {
  const sums = one.objects.map((o) => surface(o.geometry.attributes.position,
    pose.clone().multiply(one.group.matrix)));
  if (sums.length === 1) return sums[0];
  const area = sums.reduce((s, m) => s + m.area, 0) || 1;
  const centre = [0, 1, 2].map((k) => sums.reduce((s, m) => s + m.area * m.centre[k], 0) / area);
  const pairs = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];
  const moments = pairs.map(([r, c], n) => sums.reduce((s, m) =>
    s + m.area * (m.moments[n] + m.centre[r] * m.centre[c]), 0) / area - centre[r] * centre[c]);
  return {area, centre, moments};
}

let shapesCompared = 0;
function compareShapes() {
  evaluate();
  if (alone) return;
  const owners = new Map();
  for (const one of drawn.filter((d) => d.side === "mbs")) {
    owners.set(one.owner, [...(owners.get(one.owner) || []), [one, measured(one, matrix())]]);
  }
  const lostBodies = new Set();
  for (const body of [{name: null, shapes: data.mbs.base.shapes}, ...data.mbs.bodies]) {
    if (body.shapes.some((shape) => shape.mesh === null)) lostBodies.add(body.name);
  }
  const lostLinks = new Set();
  const bodyOfLink = (link) => frames.has(link) ? frames.get(link).body : undefined;
  for (const link of data.urdf.links) {
    if (link.visuals.some((visual) => visual.mesh === null)) lostLinks.add(bodyOfLink(link.name));
  }
  for (const one of drawn.filter((d) => d.side === "urdf")) {
    const owner = bodyOfLink(one.owner), pose = poses.mbs.bodies.get(owner);
    if (!pose) continue;
    const seen = measured(one, pose.clone().invert().multiply(poses.links.get(one.owner)));
    const candidates = owners.get(owner) || [];
    const match = candidates.findIndex(([, other]) => alike(seen, other));
    if (match >= 0) {
      const [[other]] = candidates.splice(match, 1);
      shapesCompared++;
      one.twin = other;
      if (one.color && other.color && one.color.some((c, k) => Math.abs(c - other.color[k]) > 0.004)) {
        one.differs = other.differs = "in colour";
      }
    } else if (!lostBodies.has(owner)) {
      one.differs = "in form or place";
    }
  }
  for (const [owner, rest] of owners) {
    for (const [one] of rest) if (!lostLinks.has(owner)) one.differs = "in form or place";
  }
}

function differs(one) {
  if (one.differs === "in form or place") return true;
  if (one.side === "urdf") return differing.has(one.owner);
  const links = linksOf.get(one.owner) || [];
  return links.some((link) => differing.has(link));
}
const linksOf = new Map();
for (const [link, at] of frames) {
  if (at.joint === null) linksOf.set(at.body, [...(linksOf.get(at.body) || []), link]);
}

// --- what is seen --------------------------------------------------------------------------------

const TINT = {mbs: new THREE.Color(0xd6273b), urdf: new THREE.Color(0x1f5fe0)};
let blink = false, ready = false;

function update() {
  evaluate();
  if (ready) {
    for (const [name, group] of holders.mbs) group.matrix.copy(poses.mbs.bodies.get(name));
    for (const [name, group] of holders.urdf) group.matrix.copy(poses.links.get(name));
    moveMarks();
  }
  show();
}

function show() {
  const side = alone ? "mbs" : document.querySelector("input[name=side]:checked").value;
  const on = (id) => byId(id) && byId(id).checked;
  sides.mbs.visible = side !== "urdf";
  sides.urdf.visible = side !== "mbs";
  for (const kind of Object.keys(kinds)) {
    for (const object of kinds[kind]) object.visible = on(`show-${kind}`);
  }
  for (const [one, object] of bones) {
    // where both agree, one skeleton is enough
    object.visible = object.visible && (side === one || one === "mbs" || differing.size > 0);
  }
  grid.visible = on("show-grid");
  const clear = on("see-through") ? 0.35 : 1;
  for (const one of drawn) {
    const off = differs(one);
    if (off && side === "both" && on("show-shapes")) one.group.visible = blink === (one.side === "mbs");
    else if (side === "both" && one.twin) one.group.visible = false;  // where both agree, one is enough
    for (const object of one.objects) tint(object, one, off && side === "both", clear);
  }
  needsRender = true;
  if (!alone) agree();
}

function agree() {
  const line = byId("agreement");
  line.textContent = "";
  const say = (kind, text) => line.append(element("span", kind, text));
  const shapes = ready && shapesCompared ? ` and ${shapesCompared} shapes` : "";
  const wrong = drawn.filter((one) => one.differs);
  if (differing.size || wrong.length) {
    const names = some([...differing]);
    const places = differing.size
      ? `${differing.size} of ${compared} link frames are elsewhere or turned (${names}), by up to ${+farthest.toPrecision(3)} m. ` : "";
    const forms = ["in form or place", "in colour"].map((how) => {
      const which = [...new Set(wrong.filter((one) => one.differs === how).map((one) => one.about))];
      return which.length ? `Shapes differ ${how}: ${some(which)}. ` : "";
    });
    say("no", places + forms.join(""));
  } else {
    say("yes", `URDF and .mbs agree here: ${compared} link frames${shapes}, apart by at most ${farthest.toExponential(1)} m`);
  }
}

const some = (names) => names.slice(0, 6).join(", ")
  + (names.length > 6 ? ` and ${names.length - 6} more` : "");

function tint(object, one, off, clear) {
  const m = object.material;
  if (!m.userData.color) {
    Object.assign(m.userData, {color: m.color.clone(), opacity: m.opacity});
  }
  m.opacity = clear * m.userData.opacity;
  m.depthWrite = m.opacity > 0.5;
  if (m.transparent !== m.opacity < 1) {
    m.transparent = m.opacity < 1;
    m.needsUpdate = true;
  }
  m.color.copy(off ? TINT[one.side] : m.userData.color);
  m.emissive.set(chosen !== undefined && bodyOfDrawn(one) === chosen ? 0x6a4a00 : 0x000000);
}

const bodyOfDrawn = (one) => one.side === "mbs" ? one.owner
  : frames.has(one.owner) ? frames.get(one.owner).body : undefined;

setInterval(() => {
  if (ready && drawn.some(differs)) window.urdf2mbs.blink();
}, 600);

const grid = new THREE.Group();
scene.add(grid);

const dark = window.matchMedia("(prefers-color-scheme: dark)").matches;
function layGrid(low) {
  const step = 10 ** Math.round(Math.log10(size / 5));
  const cells = 2 * Math.ceil(1.6 * size / step);
  const lines = new THREE.GridHelper(cells * step, cells, ...(dark ? [0x4a5564, 0x2b333e]
    : [0xaab4c2, 0xd3dae3]));
  lines.rotation.x = Math.PI / 2;
  lines.position.z = low - 1e-3 * size;
  grid.add(lines);
}

// --- the camera: turn, move, zoom ----------------------------------------------------------------

const eye = {target: new THREE.Vector3(), distance: 3 * size, around: 0.45, above: 0.32};
function aim() {
  const flat = Math.cos(eye.above);
  camera.position.set(Math.cos(eye.around) * flat, Math.sin(eye.around) * flat, Math.sin(eye.above))
    .multiplyScalar(eye.distance).add(eye.target);
  camera.near = eye.distance / 100;
  camera.far = eye.distance + 60 * size;
  camera.lookAt(eye.target);
  camera.updateProjectionMatrix();
  needsRender = true;
}

function extent() {
  const box = new THREE.Box3();
  scene.updateMatrixWorld(true);
  for (const one of drawn) {
    if (one.side === "mbs" && one.owner !== null) box.expandByObject(one.group);
  }
  for (const side of ["mbs", "urdf"]) {
    for (const [name, group] of holders[side]) {
      if (name !== null && name !== data.urdf.root) {
        box.expandByPoint(new THREE.Vector3().setFromMatrixPosition(group.matrix));
      }
    }
  }
  if (box.isEmpty()) box.expandByPoint(new THREE.Vector3());
  return box;
}

function fit() {
  const ball = extent().getBoundingSphere(new THREE.Sphere());
  // a little room around it, and more above, where the buttons are
  eye.target.copy(ball.center).setZ(ball.center.z + 0.12 * ball.radius);
  const half = camera.fov * Math.PI / 360, wide = Math.atan(Math.tan(half) * camera.aspect);
  eye.distance = 1.18 * Math.max(ball.radius, 0.05 * size) / Math.sin(Math.min(half, wide));
  aim();
}

let needsRender = true;
function frame() {
  requestAnimationFrame(frame);
  const width = view.clientWidth, height = view.clientHeight;
  if (width && height && (renderer.domElement.width !== Math.floor(width * ratio)
      || renderer.domElement.height !== Math.floor(height * ratio))) {
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height);
    camera.aspect = width / height;
    aim();
  }
  if (needsRender) {
    needsRender = false;
    renderer.render(scene, camera);
  }
}
const ratio = Math.min(window.devicePixelRatio || 1, 2);

function steer(canvas) {
  const fingers = new Map();
  let moved = 0;
  const pan = (dx, dy) => {
    const scale = 2 * eye.distance * Math.tan(camera.fov * Math.PI / 360) / view.clientHeight;
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 0);
    const up = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 1);
    eye.target.addScaledVector(right, -dx * scale).addScaledVector(up, dy * scale);
  };
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("pointerdown", (event) => {
    moved = 0;
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
    moved += Math.abs(dx) + Math.abs(dy);
    if (fingers.size === 2) {
      const other = [...fingers.values()].find((finger) => finger.pointerId !== event.pointerId);
      const span = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY);
      eye.distance *= span(before) / Math.max(span(event), 1);
      pan(dx / 2, dy / 2);
    } else if (event.buttons & 6 || event.shiftKey) {
      pan(dx, dy);
    } else {
      eye.around -= dx * 0.008;
      eye.above = Math.min(Math.max(eye.above + dy * 0.008, -1.57), 1.57);
    }
    fingers.set(event.pointerId, event);
    aim();
  });
  const lift = (event) => {
    fingers.delete(event.pointerId);
    if (event.type === "pointerup" && moved < 4 && event.button === 0) pick(event);
  };
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("dblclick", fit);
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    eye.distance *= Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.002);
    aim();
  }, {passive: false});
}

// --- choosing a body or a joint: it is marked in the 3D model, the diagram and the tables alike ---

const bodyOfJoint = new Map();
for (const body of data.mbs.bodies) {
  for (const joint of body.joints) bodyOfJoint.set(joint.name, [body, joint]);
}
const became = new Map(data.joints);

let chosen, chosenJoint;
const pick = (event) => choose(bodyUnder(event));

// the body that is under the mouse
function bodyUnder(event) {
  const box = renderer.domElement.getBoundingClientRect(), ray = new THREE.Raycaster();
  ray.setFromCamera({
    x: 2 * (event.clientX - box.left) / box.width - 1,
    y: 1 - 2 * (event.clientY - box.top) / box.height,
  }, camera);
  const targets = drawn.filter((one) => one.group.visible && sides[one.side].visible)
    .flatMap((one) => one.objects);
  const found = ray.intersectObjects(targets)[0];
  return found && bodyOfDrawn(found.object.userData.drawn);
}

const bodyOfLink = (link) => frames.has(link) ? frames.get(link).body : undefined;
const chooseJoint = (name) => choose(bodyOfJoint.get(name)[0].name, name);

// name: a body's, null for the base, undefined for nothing; joint: one of the body's
function choose(name, joint) {
  chosen = name;
  chosenJoint = joint;
  const about = byId("picked"), body = bodyOf.get(name);
  about.textContent = "";
  if (name === null) about.textContent = `base: ${data.mbs.base.name}`;
  if (body) {
    const links = linksOf.get(name) || [];
    const told = ({name: own, type, nature}) => `q${numbers.get(own)} ${type} ${own}, ${nature}`;
    const joints = body.joints.map((one) => `q${numbers.get(one.name)} ${one.type} ${one.name}`);
    about.append(element("b", "", body.name),
      joint === undefined ? "" : `\njoint: ${told(bodyOfJoint.get(joint)[1])}`,
      (alone ? "" : `\nlinks: ${links.slice(0, 8).join(", ")}${links.length > 8 ? ", ..." : ""}`)
      + `\nmass: ${body.mass === null ? "none" : `${+body.mass.toPrecision(6)} kg`}`
      + (joint === undefined
        ? `\njoints: ${joints.slice(0, 8).join("; ")}${joints.length > 8 ? "; ..." : ""}` : ""));
  }
  for (const marked of document.querySelectorAll(".chosen")) marked.classList.remove("chosen");
  if (name !== undefined) {
    for (const one of document.querySelectorAll("[data-body]:not(.point)")) {
      if (one.dataset.body === (name || "")) one.classList.add("chosen");
    }
    for (const one of document.querySelectorAll("[data-link]")) {
      if (bodyOfLink(one.dataset.link) === name) one.classList.add("chosen");
    }
    for (const one of document.querySelectorAll("[data-joint]:not(input), [data-urdf-joint]")) {
      const names = one.dataset.joint ? [one.dataset.joint] : became.get(one.dataset.urdfJoint) || [];
      const has = joint === undefined ? body && body.joints.some((own) => names.includes(own.name))
        : names.includes(joint);
      if (has) one.classList.add("chosen");
    }
  }
  point(null);
  show();
}

// what a row of a table, an entry of the tree or a slider stands for
function chooseWhat(row) {
  const {joint, urdfJoint, body, link} = row.dataset;
  const first = (became.get(urdfJoint) || [])[0];
  // of the joints that a URDF joint became, the one that moves
  const real = (became.get(urdfJoint) || []).find((name) => q.has(name)) || first;
  if (joint !== undefined) chooseJoint(joint);
  else if (real !== undefined) chooseJoint(real);
  else if (body !== undefined) choose(body || null);
  else if (link !== undefined) choose(bodyOfLink(link));
}

function makeChoosable(row) {
  row.tabIndex = 0;
  row.classList.add("choosable");
  row.addEventListener("click", () => chooseWhat(row));
  row.addEventListener("keydown", (event) => {
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      chooseWhat(row);
    }
  });
}

// the axis of the joint whose slider is under the pointer, else of the one that is chosen
let arrow = null;
function point(joint) {
  if (arrow) scene.remove(arrow);
  arrow = null;
  joint = joint || (chosenJoint === undefined ? null : bodyOfJoint.get(chosenJoint)[1]);
  if (joint && poses) {
    const pose = poses.mbs.joints.get(joint.name);
    const along = new THREE.Vector3().setFromMatrixColumn(pose, +joint.type[1] - 1);
    arrow = new THREE.ArrowHelper(along, new THREE.Vector3().setFromMatrixPosition(pose),
      size * 0.22, 0xd6273b, size * 0.05, size * 0.025);
    for (const part of [arrow.line, arrow.cone]) {
      part.material.depthTest = false;
      part.material.transparent = true;
      part.renderOrder = 9;
    }
    scene.add(arrow);
  }
  needsRender = true;
}

// --- the sliders -----------------------------------------------------------------------------------

function makeSliders() {
  const list = byId("sliders");
  // the base comes last: one moves the robot's own joints first
  for (const joint of [...moving].sort((a, b) => base.has(a.name) - base.has(b.name))) {
    const turns = joint.type[0] === "R", [low, high] = limits.get(joint.name);
    const row = element("div", "slider"), top = element("div", "top");
    const name = element("span", "name", joint.name);
    name.title = joint.name;
    name.onclick = () => chooseJoint(joint.name);
    row.dataset.joint = joint.name;
    const range = element("input"), box = element("input"), ends = element("div", "ends");
    range.type = "range";
    Object.assign(range, {min: low, max: high, step: "any"});
    range.setAttribute("aria-label", joint.name);
    range.dataset.joint = joint.name;
    box.type = "number";
    box.step = "any";
    box.setAttribute("aria-label", `value of ${joint.name}`);
    const factor = () => byId("unit").value === "rad" ? 1 : turns ? 180 / Math.PI : 1000;
    const unit = () => byId("unit").value === "rad" ? turns ? " rad" : " m" : turns ? "°" : " mm";
    const word = (value) => `${+(value * factor()).toFixed(byId("unit").value === "rad" ? 4 : 1)}`;
    const change = (value) => {
      set(joint.name, value);
      settle();
      point(joint);
    };
    range.addEventListener("input", () => {
      // at its ends a slider gives the limits but for their last digits
      const end = [low, high].find((limit) => Math.abs(range.value - limit) < 1e-9 * (high - low));
      change(end === undefined ? +range.value : end);
    });
    box.addEventListener("change", () => change(+box.value / factor()));
    row.addEventListener("pointerenter", () => point(joint));
    row.addEventListener("pointerleave", () => point(null));
    range.addEventListener("focus", () => point(joint));
    range.addEventListener("blur", () => point(null));
    top.append(name, element("span", "q", `q${numbers.get(joint.name)} ${joint.type}`), box);
    const [min, max] = [element("span"), element("span")];
    ends.append(min, max);
    row.append(top, range, ends);
    list.append(row);
    sliders.set(joint.name, (value) => {
      range.value = value;
      box.value = word(value);
      min.textContent = `${word(low)}${unit()}`;
      max.textContent = `${word(high)}${unit()}`;
      const led = byId("mimic").checked && follows.has(joint.name);
      range.disabled = box.disabled = led;
      row.classList.toggle("follows", led);
      name.title = led ? `${joint.name} follows ${follows.get(joint.name)[0]}` : joint.name;
    });
  }
  if (!moving.length) list.append(element("p", "note", "No joint of this robot moves."));
  byId("mimic-label").hidden = !follows.size;
  const all = (value) => {
    for (const joint of moving) set(joint.name, value(joint));
    settle();
  };
  byId("zero").onclick = () => all(() => 0);
  byId("start").onclick = () => all((joint) => joint.q || 0);
  byId("random").onclick = () => all((joint) => {
    const [low, high] = limits.get(joint.name);
    return base.has(joint.name) ? q.get(joint.name) : low + (high - low) * Math.random();
  });
  byId("mimic").onchange = byId("unit").onchange = settle;
  byId("filter-sliders").oninput = (event) => {
    const wanted = event.target.value.toLowerCase();
    for (const row of [...list.children, ...byId("tree").children]) {
      row.hidden = !row.textContent.toLowerCase().includes(wanted);
    }
  };
}

// --- the tree of links, or of bodies where there is no URDF -----------------------------------------------------------------------------

function makeTree() {
  const tree = byId("tree"), below = new Map();
  const parts = alone
    ? data.mbs.bodies.map(({name, parent, joints}) =>
      ({name, parent, about: joints.map((joint) => `${joint.type} ${joint.name}`).join(", ")}))
    : data.urdf.joints.map(({child, parent, type, name}) =>
      ({name: child, parent, about: `${type} ${name}`}));
  for (const part of parts) below.set(part.parent, [...(below.get(part.parent) || []), part]);
  const todo = [[{name: data.urdf.root, about: ""}, 0]];
  while (todo.length) {
    const [{name, about}, depth] = todo.pop();
    const row = element("div", "link", name === null ? data.mbs.base.name : name);
    row.style.paddingLeft = `${6 + 13 * Math.min(depth, 14)}px`;
    if (about) row.append(element("span", "q", ` ${about}`));
    row.dataset[alone ? "body" : "link"] = name || "";
    makeChoosable(row);
    tree.append(row);
    for (const next of (below.get(name) || []).reverse()) todo.push([next, depth + 1]);
  }
  const turn = (links) => {
    tree.hidden = !links;
    byId("sliders").hidden = links;
    byId("as-links").setAttribute("aria-pressed", links);
    byId("as-joints").setAttribute("aria-pressed", !links);
  };
  byId("as-links").onclick = () => turn(true);
  byId("as-joints").onclick = () => turn(false);
}
const base = new Set(data.urdf.joints.filter((joint) => joint.type === "floating")
  .flatMap((joint) => coordinates.get(joint.name) || []));

// --- the diagram: moved by dragging, zoomed by the wheel --------------------------------------------

function paper() {
  const sheet = byId("paper"), svg = sheet.querySelector("svg");
  if (!svg) return;
  const full = svg.viewBox.baseVal;
  const whole = [full.x, full.y, full.width, full.height];
  let box = whole;
  const set = (next) => {
    box = next;
    svg.setAttribute("viewBox", box.join(" "));
  };
  const scale = () => Math.max(box[2] / svg.clientWidth, box[3] / svg.clientHeight);
  svg.removeAttribute("width");
  svg.removeAttribute("height");
  const fitAll = () => set(whole);
  const fullSize = () => set([whole[0], whole[1], svg.clientWidth, svg.clientHeight]);
  byId("diagram-fit").onclick = fitAll;
  byId("diagram-full").onclick = fullSize;
  byId("diagram-save").onclick = () => {
    const copy = svg.cloneNode(true);
    copy.setAttribute("viewBox", whole.join(" "));
    copy.setAttribute("width", whole[2]);
    copy.setAttribute("height", whole[3]);
    save(URL.createObjectURL(new Blob([new XMLSerializer().serializeToString(copy)],
      {type: "image/svg+xml"})), `${data.name}.svg`);
  };
  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    const area = svg.getBoundingClientRect();
    const by = Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.003);
    const k = scale();
    const x = box[0] + box[2] / 2 + (event.clientX - area.left - area.width / 2) * k;
    const y = box[1] + box[3] / 2 + (event.clientY - area.top - area.height / 2) * k;
    set([x - (x - box[0]) * by, y - (y - box[1]) * by, box[2] * by, box[3] * by]);
  }, {passive: false});
  let held = null, moved = 0;
  svg.addEventListener("pointerdown", (event) => { held = event; moved = 0; });
  window.addEventListener("pointermove", (event) => {
    if (!held) return;
    const k = scale(), dx = event.clientX - held.clientX, dy = event.clientY - held.clientY;
    moved += Math.abs(dx) + Math.abs(dy);
    set([box[0] - dx * k, box[1] - dy * k, box[2], box[3]]);
    held = event;
  });
  window.addEventListener("pointerup", () => { held = null; });
  svg.addEventListener("click", (event) => {
    if (moved >= 4) return;
    const what = event.target.closest("[data-joint], [data-body]");
    if (what) chooseWhat(what);
    else choose(undefined);
  });
  // on paper there is all of it
  let before = whole;
  window.addEventListener("beforeprint", () => { before = box; fitAll(); });
  window.addEventListener("afterprint", () => set(before));
}

function save(url, name) {
  const link = element("a");
  link.href = url;
  link.download = name;
  link.click();
}

function tables() {
  for (const filter of document.querySelectorAll("input.filter")) {
    const rows = filter.closest("section").querySelectorAll("tbody tr");
    filter.oninput = () => {
      const wanted = filter.value.toLowerCase();
      for (const row of rows) row.hidden = !row.textContent.toLowerCase().includes(wanted);
    };
  }
  const rows = "tr[data-body], tr[data-joint], tr[data-link], tr[data-urdf-joint]";
  document.querySelectorAll(rows).forEach(makeChoosable);
}

// --- arrows of forces: at a point of a body, in the axes of the base; ``most`` is half the robot ---

function makeArrows(kinds) {
  const arrows = kinds.map((pushed) => {
    const arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1,
      pushed ? MARK.stops : MARK.forces);
    arrow.visible = false;
    for (const part of pushed ? [arrow.line, arrow.cone] : []) {
      part.material.depthTest = false;  // it begins inside the body
      part.renderOrder = 9;
    }
    scene.add(arrow);
    return arrow;
  });
  return (k, pose, at, force, most) => {
    const length = Math.hypot(...force) / most * size / 2;
    arrows[k].visible = length > 0.002 * size && byId("show-forces").checked;
    if (!arrows[k].visible) return;
    arrows[k].position.set(...at).applyMatrix4(pose);
    arrows[k].setDirection(new THREE.Vector3(...force).normalize());
    arrows[k].setLength(length, Math.min(size / 20, length / 2), size / 40);
  };
}

// --- the motion of a simulated project --------------------------------------------------------------

const player = {time: 0, playing: false, at: null, play: () => {}};
function makePlayer() {
  const {joints, forces, ...packed} = data.motion;
  const floats = (text) => new Float32Array(
    Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
  const [times, positions, loads, energies] = [packed.time, packed.q, packed.F, packed.E].map(floats);
  const last = times.length - 1, scrub = byId("scrub"), button = byId("play");
  const arrow = makeArrows(forces.map(([, , pushed]) => pushed));
  const force = (k, frame) => loads.subarray(6 * (frame * forces.length + k),
    6 * (frame * forces.length + k) + 6);
  const newton = (k, frame) => Math.hypot(...force(k, frame).subarray(0, 3));
  let most = 1e-9;
  for (let i = 0; i <= last; i++) forces.forEach((_, k) => { most = Math.max(most, newton(k, i)); });

  // the frame at or before a time
  const frameAt = (time) => {
    let low = 0, high = last;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= time + 1e-6) low = middle; else high = middle - 1;
    }
    return low;
  };
  const coordinate = (frame, j) => positions[frame * joints.length + j];
  let trail = null, trailOf;
  const drawTrail = () => {
    const body = byId("trail").checked && bodyOf.has(chosen) ? chosen : undefined;
    if (body === trailOf) return;
    trailOf = body;
    if (trail) scene.remove(trail);
    trail = null;
    if (body === undefined) return;
    const points = Array.from(times, (_, i) => new THREE.Vector3().setFromMatrixPosition(
      mbsPoses(new Map(joints.map((name, j) => [name, coordinate(i, j)]))).bodies.get(body)));
    trail = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
      new THREE.LineBasicMaterial({color: MARK.stops}));
    scene.add(trail);
  };

  player.at = (time) => {
    player.time = Math.min(Math.max(time, times[0]), times[last]);
    const frame = frameAt(player.time);
    joints.forEach((name, j) => q.set(name, coordinate(frame, j)));
    settle();
    forces.forEach(([body], k) => {
      const [x, y, z, ...at] = force(k, frame);
      arrow(k, poses.mbs.bodies.get(body), at, [x, y, z], most);
    });
    drawTrail();
    scrub.value = player.time;
    byId("clock").textContent = `${player.time.toFixed(2)} s`;
    drawCurves();
  };

  const canvas = byId("curves"), pen = canvas.getContext("2d"), choice = byId("curve");
  // the groups of curves: what each is called, and its value in a frame
  const groups = {
    Joints: joints.map((name, j) => [name, (frame) => coordinate(frame, j)]),
    Forces: forces.map(([, name], k) => [`|${name}| (N)`, (frame) => newton(k, frame)]),
    Energy: energies.length ? [["kinetic (J)", (frame) => energies[2 * frame]],
      ["potential (J)", (frame) => energies[2 * frame + 1]],
      ["sum (J)", (frame) => energies[2 * frame] + energies[2 * frame + 1]]] : [],
  };
  const curves = Object.entries(groups).filter(([, lines]) => lines.length);
  for (const lines of [groups.Joints, groups.Forces]) curves.push(...lines.map((line) => [line[0], [line]]));
  curves.forEach(([name], k) => choice.add(new Option(name, k)));
  function drawCurves() {
    const width = canvas.width = canvas.clientWidth || 600, height = canvas.height;
    const lines = curves[choice.value][1];
    const span = times[last] - times[0] || 1;
    let low = Infinity, high = -Infinity;
    for (const [, value] of lines) {
      for (let i = 0; i <= last; i++) {
        low = Math.min(low, value(i));
        high = Math.max(high, value(i));
      }
    }
    const x = (time) => (time - times[0]) / span * width;
    const y = (v) => height - 8 - (v - low) / (high - low || 1) * (height - 16);
    const frame = frameAt(player.time);
    lines.forEach(([name, value], n) => {
      pen.strokeStyle = pen.fillStyle = `hsl(${n * 137.5 % 360} 60% 48%)`;
      pen.beginPath();
      times.forEach((time, i) => pen.lineTo(x(time), y(value(i))));
      pen.stroke();
      if (lines.length < 9) pen.fillText(`${name}: ${+value(frame).toPrecision(4)}`, 60, 12 + 12 * n);
    });
    pen.fillStyle = pen.strokeStyle = getComputedStyle(canvas).color;
    pen.fillText(`${+high.toPrecision(4)}`, 4, 12);
    pen.fillText(`${+low.toPrecision(4)}`, 4, height - 4);
    pen.strokeRect(x(player.time), 0, 0.5, height);
  }

  player.play = (on) => {
    player.playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (player.time >= times[last]) player.at(times[0]);
    let before = performance.now();
    const step = (now) => {
      if (!player.playing) return;
      let time = player.time + Math.max(now - before, 0) / 1000 * byId("speed").value;
      before = now;
      if (time >= times[last] && byId("repeat").checked) time = times[0];
      player.at(time);
      if (player.time >= times[last] && !byId("repeat").checked) player.play(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  };
  button.onclick = () => player.play(!player.playing);
  scrub.min = times[0];
  scrub.max = times[last];
  scrub.oninput = () => { player.play(false); player.at(+scrub.value); };
  canvas.onclick = (event) => player.at(
    times[0] + event.offsetX / canvas.clientWidth * (times[last] - times[0]));
  choice.onchange = byId("trail").onchange = () => player.at(player.time);
  document.addEventListener("keydown", (event) => {
    // a button, a field or a row takes the space itself
    if (event.key !== " " || event.target !== document.body) return;
    event.preventDefault();
    button.click();
  });
  byId("player").hidden = false;
  player.at(times[0]);
}

// --- all together ------------------------------------------------------------------------------------

const pose = (m) => {
  const e = m.elements;
  return [0, 1, 2, 3].map((r) => [e[r], e[4 + r], e[8 + r], e[12 + r]]);
};
// what a test, or a curious reader at the console, may ask
window.urdf2mbs = {
  ready: null,
  set: (name, value) => { set(name, value); settle(); },
  position: (name) => q.get(name),
  body: (name) => pose(poses.mbs.bodies.get(name)),
  link: (name) => pose(poses.links.get(name)),
  seen: (side, name) => {
    scene.updateMatrixWorld(true);
    return pose(holders[side].get(name).matrixWorld);
  },
  agreement: () => ({largest, compared, differing: [...differing], shapes: shapesCompared,
    shapesDiffering: drawn.filter((one) => one.differs)
      .map((one) => [one.side, one.about, one.differs])}),
  counts: () => ({mbs: drawn.filter((one) => one.side === "mbs").length,
    urdf: drawn.filter((one) => one.side === "urdf").length, lost: missing.length}),
  limits: (name) => limits.get(name),
  lit: (link) => drawn.filter((one) => one.group.visible && bodyOfDrawn(one) === frames.get(link).body)
    .map((one) => one.side),
  marks: (kind) => {
    scene.updateMatrixWorld(true);
    return kinds[kind].filter((one) => one.visible && one.geometry && one.isMesh)
      .map((one) => new THREE.Vector3().setFromMatrixPosition(one.matrixWorld).toArray());
  },
  ends: () => lines.map(([line]) => [...line.geometry.attributes.position.array]),
  stops: () => stops.map((one) => ({joint: one.joint.name, low: one.low, high: one.high,
    beyond: beyond(one), hand: pose(one.group.matrix.clone().multiply(one.hand.matrix))})),
  arrows: () => scene.children.filter((one) => one.cone && one.visible).map((one) => one.position.toArray()),
  picture,
  player,
  blink: () => { blink = !blink; show(); },
  inertiaCorners: (name) => {
    const box = kinds.inertias.find((one) => one.parent === holders.mbs.get(name));
    const at = box.geometry.attributes.position, corners = [];
    for (let i = 0; i < at.count; i++) {
      corners.push(new THREE.Vector3().fromBufferAttribute(at, i).applyMatrix4(box.matrix).toArray());
    }
    return corners;
  },
  bounds: (side, name) => {
    scene.updateMatrixWorld(true);
    const box = new THREE.Box3();
    for (const one of drawn) if (one.side === side && one.owner === name) box.expandByObject(one.group);
    return [box.min.toArray(), box.max.toArray()];
  },
};

makeSliders();
makeTree();
paper();
tables();
settle();
for (const input of document.querySelectorAll(".view .bar input")) input.onchange = show;

function picture() {
  renderer.render(scene, camera);
  return renderer.domElement.toDataURL();
}

// the moving picture, from one press of the button to the next
let recorder = null;
function record() {
  if (recorder) return recorder.stop();
  const parts = [], type = ["video/webm", "video/mp4"].find((kind) => MediaRecorder.isTypeSupported(kind));
  scene.background = new THREE.Color(dark ? 0x1b222b : 0xf2f5f9);  // the page's is not in the video
  recorder = new MediaRecorder(renderer.domElement.captureStream(), {mimeType: type, videoBitsPerSecond: 8e6});
  recorder.ondataavailable = (event) => parts.push(event.data);
  recorder.onstop = () => {
    recorder = scene.background = null;
    byId("record").textContent = "Record";
    show();
    save(URL.createObjectURL(new Blob(parts, {type})), `${data.name}.${type.slice(6)}`);
  };
  recorder.start();
  byId("record").textContent = "Stop recording";
  show();
}

async function open() {
  if (data.meshes.length) array = await unpack();
  textures = await Promise.all(data.textures.map(async (url) => {
    const image = new Image();
    image.src = url;
    const texture = new THREE.Texture(image);
    texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
    try {
      await image.decode();
      texture.needsUpdate = true;
    } catch {
      console.warn("a texture could not be read");
    }
    return texture;
  }));
  build();
  ready = true;
  if (!drawn.length) byId("show-skeleton").checked = true;
  update();
  const low = extent().min.z;
  layGrid(Number.isFinite(low) ? low : 0);
  if (renderer) {
    view.append(renderer.domElement);
    steer(renderer.domElement);
    byId("fit").onclick = fit;
    byId("picture").onclick = () => save(picture(), `${data.name}.png`);
    byId("record").onclick = record;
    byId("record").hidden = !data.motion || typeof MediaRecorder === "undefined";
    camera.aspect = view.clientWidth / Math.max(view.clientHeight, 1);
    fit();
    frame();
  }
  show();
  if (data.motion) makePlayer();
}
window.urdf2mbs.ready = open();
})();
