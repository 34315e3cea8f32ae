// Triangles: meshes out of the page's arrays, simple solids, and what a surface measures.

import {byId, data, unzip} from "./basics.js";

// 32-bit words of all meshes, and how page.py has packed them
let allWords = null, textures = [];
function words([place, length]) {
  const bytes = new Uint8Array(allWords, place, 4 * length), out = new Uint8Array(4 * length);
  for (let k = 0; k < length; k++) {
    for (let b = 0; b < 4; b++) out[4 * k + b] = bytes[b * length + k];
  }
  return new Uint32Array(out.buffer);
}

function cornersOf(part) {
  let next = 0;
  return words(part.triangles).map((back) => {
    const point = next - back;
    next = Math.max(next, point + 1);
    return point;
  });
}

// x, y and z of each point: all x come first, each as steps from that of the point before
function pointsOf(part) {
  const steps = words(part.points), count = steps.length / 3, points = new Float32Array(3 * count);
  for (let axis = 0; axis < 3; axis++) {
    for (let k = 0, at = 0; k < count; k++) {
      at = at + steps[axis * count + k] & 65535;
      points[3 * k + axis] = part.low[axis] + at * part.step;
    }
  }
  return points;
}

export async function unpack() {
  allWords = await unzip(byId("arrays").textContent.trim());
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
}

const cache = new Map();
const once = (key, make) => cache.get(key) || cache.set(key, make()).get(key);
const solid = (Kind, ...sizes) => once(`${Kind.name} ${sizes}`, () => new Kind(...sizes).toNonIndexed());
export const primitive = {
  box: ([x, y, z]) => solid(THREE.BoxGeometry, x, y, z),
  sphere: (r) => solid(THREE.SphereGeometry, r, 40, 24),
  ball: (r) => solid(THREE.SphereGeometry, r, 12, 8),  // a mark: there are many
  cylinder: (r, h) => solid(THREE.CylinderGeometry, r, r, h, 40),
  cone: (r, h) => solid(THREE.ConeGeometry, r, h, 40),
};

// a mesh: of each part the geometry, its own colour, opacity and texture, if it has these
export function meshParts(number) {
  return data.meshes[number].map((part) => ({
    geometry: once(JSON.stringify([part.points, part.low, part.step, part.triangles, part.uv, part.colors]),
      () => meshGeometry(part)),
    map: textures[part.texture] || null,
    vertexColors: part.colors !== undefined,
    color: part.color,
    opacity: part.transparency === null ? null : 1 - part.transparency,
  }));
}

function meshGeometry(part) {
  const points = pointsOf(part), index = cornersOf(part);
  const position = new Float32Array(3 * index.length);
  index.forEach((point, corner) => position.set(points.subarray(3 * point, 3 * point + 3), 3 * corner));
  const geometry = new THREE.BufferGeometry();
  const put = (name, values, count, ...more) =>
    geometry.setAttribute(name, new THREE.BufferAttribute(values, count, ...more));
  put("position", position, 3);
  put("normal", smoothNormals(position, index), 3);
  if (part.uv) put("uv", new Float32Array(words(part.uv).buffer), 2);
  if (part.colors) put("color", new Uint8Array(words(part.colors).buffer), 4, true);
  return geometry;
}

// a corner's normal is the sum of those of the faces at its point that meet at less than 0.5 rad
function smoothNormals(position, index) {
  const flat = new THREE.BufferGeometry();
  flat.setAttribute("position", new THREE.BufferAttribute(position, 3));
  flat.computeVertexNormals();  // no corner is shared: these are the normals of the faces
  const faces = flat.attributes.normal.array, normals = new Float32Array(faces.length);
  let most = -1;
  for (const point of index) most = Math.max(most, point);
  // the corners at point k are those from about[k] to about[k + 1] of corners
  const about = new Uint32Array(most + 2), corners = new Uint32Array(index.length);
  for (const point of index) about[point + 1]++;
  for (let k = 1; k < about.length; k++) about[k] += about[k - 1];
  const free = about.slice();
  index.forEach((point, corner) => { corners[free[point]++] = 3 * corner; });
  const crease = Math.cos(0.5);
  index.forEach((point, corner) => {
    const at = 3 * corner, nx = faces[at], ny = faces[at + 1], nz = faces[at + 2];
    let x = 0, y = 0, z = 0;
    for (let i = about[point]; i < about[point + 1]; i++) {
      const f = corners[i];
      if (faces[f] * nx + faces[f + 1] * ny + faces[f + 2] * nz >= crease) {
        x += faces[f]; y += faces[f + 1]; z += faces[f + 2];
      }
    }
    const length = Math.hypot(x, y, z) || 1;
    normals.set([x / length, y / length, z / length], at);
  });
  return normals;
}

// area, centroid and second moments of surfaces: equal for equal shapes, however cut up
const PAIRS = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];
export function surface(objects, transform) {
  let area = 0;
  const first = [0, 0, 0], second = [0, 0, 0, 0, 0, 0];
  const v = [0, 1, 2].map(() => new THREE.Vector3()), e = new THREE.Vector3(), g = new THREE.Vector3();
  for (const {geometry: {attributes: {position}}} of objects) {
    for (let i = 0; i + 2 < position.count; i += 3) {
      for (let k = 0; k < 3; k++) v[k].fromBufferAttribute(position, i + k).applyMatrix4(transform);
      const a = e.subVectors(v[1], v[0]).cross(g.subVectors(v[2], v[0])).length() / 2;
      area += a;
      const sum = v.reduce((s, p) => [s[0] + p.x, s[1] + p.y, s[2] + p.z], [0, 0, 0]);
      for (let k = 0; k < 3; k++) first[k] += a * sum[k] / 3;
      PAIRS.forEach(([r, c], n) => {
        const products = v.reduce((s, p) => s + p.getComponent(r) * p.getComponent(c), 0);
        second[n] += a * (products + sum[r] * sum[c]) / 12;
      });
    }
  }
  const centre = first.map((c) => c / (area || 1));
  const moments = PAIRS.map(([r, c], n) => second[n] / (area || 1) - centre[r] * centre[c]);
  return {area, centre, moments};
}
