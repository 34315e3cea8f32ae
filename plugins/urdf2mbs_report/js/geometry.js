// Triangles: meshes from the page's arrays, simple solids, and measures of a surface.

import {byId, data, decompress, vector} from "./basics.js";

// --- the arrays of meshes, which mesh_store.py has packed ---

let packedArrays = null, meshTextures = [];

export async function unpackMeshes() {
  packedArrays = await decompress(byId("arrays").textContent.trim());
  meshTextures = await Promise.all(data.textures.map(async (url) => {
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

// An array of 32-bit words: all lowest bytes come first, then the next ones.
function readWords([firstByte, wordCount]) {
  const packed = new Uint8Array(packedArrays, firstByte, 4 * wordCount);
  const bytes = new Uint8Array(4 * wordCount);
  for (let word = 0; word < wordCount; word++) {
    for (let byte = 0; byte < 4; byte++) bytes[4 * word + byte] = packed[byte * wordCount + word];
  }
  return new Uint32Array(bytes.buffer);
}

// The index of the point at each corner: packed is its distance from the next new index.
function decodeIndices(part) {
  let nextNew = 0;
  return readWords(part.triangles).map((distance) => {
    const index = nextNew - distance;
    nextNew = Math.max(nextNew, index + 1);
    return index;
  });
}

// x, y and z of each point: all x come first, each as steps (modulo 65536) from the point before.
function decodePoints(part) {
  const steps = readWords(part.points), count = steps.length / 3;
  const points = new Float32Array(3 * count);
  for (let axis = 0; axis < 3; axis++) {
    for (let point = 0, multiple = 0; point < count; point++) {
      multiple = multiple + steps[axis * count + point] & 65535;
      points[3 * point + axis] = part.low[axis] + multiple * part.step;
    }
  }
  return points;
}

// --- geometries, each of which is made once ---

const geometryCache = new Map();
function cached(key, make) {
  if (!geometryCache.has(key)) geometryCache.set(key, make());
  return geometryCache.get(key);
}

const makeSolid = (Solid, ...sizes) =>
  cached(`${Solid.name} ${sizes}`, () => new Solid(...sizes).toNonIndexed());
export const solids = {
  box: ([x, y, z]) => makeSolid(THREE.BoxGeometry, x, y, z),
  sphere: (radius) => makeSolid(THREE.SphereGeometry, radius, 40, 24),
  ball: (radius) => makeSolid(THREE.SphereGeometry, radius, 12, 8),  // coarse, as there are many
  cylinder: (radius, height) => makeSolid(THREE.CylinderGeometry, radius, radius, height, 40),
  cone: (radius, height) => makeSolid(THREE.ConeGeometry, radius, height, 40),
};

// The parts of a mesh: the geometry of each, and its own colour, opacity and texture, or null.
export function getMeshParts(number) {
  return data.meshes[number].map((part) => ({
    geometry: cached(
      JSON.stringify([part.points, part.low, part.step, part.triangles, part.uv, part.colors]),
      () => makeMeshGeometry(part)),
    map: meshTextures[part.texture] || null,
    vertexColors: part.colors !== undefined,
    color: part.color,
    opacity: part.transparency === null ? null : 1 - part.transparency,
  }));
}

function makeMeshGeometry(part) {
  const points = decodePoints(part), indices = decodeIndices(part);
  const corners = new Float32Array(3 * indices.length);
  indices.forEach((point, corner) =>
    corners.set(points.subarray(3 * point, 3 * point + 3), 3 * corner));
  const geometry = new THREE.BufferGeometry();
  const setAttribute = (name, values, count, ...options) =>
    geometry.setAttribute(name, new THREE.BufferAttribute(values, count, ...options));
  setAttribute("position", corners, 3);
  setAttribute("normal", computeNormals(corners, indices), 3);
  if (part.uv) setAttribute("uv", new Float32Array(readWords(part.uv).buffer), 2);
  if (part.colors) setAttribute("color", new Uint8Array(readWords(part.colors).buffer), 4, true);
  return geometry;
}

// Faces that meet at less than this angle (rad) are shaded as one smooth surface, as in vrml.py.
const CREASE_ANGLE = 0.5;

// The normals of corners: each is the sum of those of the faces at its point that meet its own
// face at less than CREASE_ANGLE.
function computeNormals(corners, indices) {
  const flat = new THREE.BufferGeometry();
  flat.setAttribute("position", new THREE.BufferAttribute(corners, 3));
  flat.computeVertexNormals();  // no corner is shared, so these are the normals of the faces
  const faceNormals = flat.attributes.normal.array, normals = new Float32Array(faceNormals.length);
  const {firstCorners, cornersByPoint} = groupCorners(indices);
  const minCosine = Math.cos(CREASE_ANGLE);
  indices.forEach((point, corner) => {
    const own = 3 * corner;
    const nx = faceNormals[own], ny = faceNormals[own + 1], nz = faceNormals[own + 2];
    let x = 0, y = 0, z = 0;
    for (let k = firstCorners[point]; k < firstCorners[point + 1]; k++) {
      const next = 3 * cornersByPoint[k];
      const cosine = faceNormals[next] * nx + faceNormals[next + 1] * ny + faceNormals[next + 2] * nz;
      if (cosine >= minCosine) {
        x += faceNormals[next];
        y += faceNormals[next + 1];
        z += faceNormals[next + 2];
      }
    }
    const length = Math.hypot(x, y, z) || 1;
    normals.set([x / length, y / length, z / length], own);
  });
  return normals;
}

// The corners at each point: those at point p are cornersByPoint[k], with k from firstCorners[p]
// to firstCorners[p + 1] - 1.
function groupCorners(indices) {
  let lastPoint = -1;
  for (const point of indices) lastPoint = Math.max(lastPoint, point);
  const firstCorners = new Uint32Array(lastPoint + 2);
  for (const point of indices) firstCorners[point + 1]++;
  for (let point = 1; point < firstCorners.length; point++) {
    firstCorners[point] += firstCorners[point - 1];
  }
  const nextFree = firstCorners.slice(), cornersByPoint = new Uint32Array(indices.length);
  indices.forEach((point, corner) => { cornersByPoint[nextFree[point]++] = corner; });
  return {firstCorners, cornersByPoint};
}

// --- measures ---

// The entries of a symmetric matrix.
const MATRIX_ENTRIES = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]];

// The area (m^2), centroid (m) and second moments (m^2, divided by the area) of surfaces.  They are
// equal for equal surfaces, whatever their triangles are.
//
// A triangle with the area A and the corners p, q, r adds to the first moment A s / 3, and to the
// second moments A (p p^T + q q^T + r r^T + s s^T) / 12, where s = p + q + r.
export function measureSurface(meshes, transform) {
  let area = 0;
  const firstMoments = [0, 0, 0], secondMoments = [0, 0, 0, 0, 0, 0];
  const corners = [vector(), vector(), vector()], edge1 = vector(), edge2 = vector();
  for (const {geometry: {attributes: {position}}} of meshes) {
    for (let first = 0; first + 2 < position.count; first += 3) {
      corners.forEach((corner, k) =>
        corner.fromBufferAttribute(position, first + k).applyMatrix4(transform));
      edge1.subVectors(corners[1], corners[0]);
      edge2.subVectors(corners[2], corners[0]);
      const triangleArea = edge1.cross(edge2).length() / 2;
      area += triangleArea;
      const sum = corners.reduce((s, p) => [s[0] + p.x, s[1] + p.y, s[2] + p.z], [0, 0, 0]);
      for (let axis = 0; axis < 3; axis++) firstMoments[axis] += triangleArea * sum[axis] / 3;
      MATRIX_ENTRIES.forEach(([row, column], entry) => {
        const products = corners.reduce(
          (s, p) => s + p.getComponent(row) * p.getComponent(column), 0);
        secondMoments[entry] += triangleArea * (products + sum[row] * sum[column]) / 12;
      });
    }
  }
  const centre = firstMoments.map((moment) => moment / (area || 1));
  const moments = MATRIX_ENTRIES.map(([row, column], entry) =>
    secondMoments[entry] / (area || 1) - centre[row] * centre[column]);
  return {area, centre, moments};
}
