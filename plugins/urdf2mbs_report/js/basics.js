// The data of the page, look-ups by name, and small helpers.

// What page.py writes into the page; lengths are in m, angles in rad:
//   mbs: base {name, shapes}, bodies [{name, parent, at, joints, mass, com, inertia, shapes}]
//   urdf: root, links [{name, visuals, collisions}], joints [{name, type, parent, child, ...}]
//   frames, coordinates, joints: pairs of a URDF name and what it is in the .mbs
//   meshes: of each its parts, whose arrays are [first byte, number of words]; textures: urls
//   marks: points [body, xyz, kind, rotation], lines [kind, end, end], stops [joint, [low, high]],
//     ground: its height
//   cuts [{kind, name, first, second, length}]; followers [joint, leader, factor, offset]
//   standIns: collision shapes {link, body, pose, xyz, rpy, geometry, mesh} in place of visuals
//   motion: null, or what motion.py has read; modes: null, or those of modal.py
export const data = JSON.parse(document.getElementById("data").textContent);
// The page of an .mbs alone has no URDF.
export const isModelAlone = data.urdf.root === null;
// The size of the robot (m).
export const robotSize = data.size;

// --- helpers ---

export const byId = (id) => document.getElementById(id);
export const matrix = () => new THREE.Matrix4();
export const vector = (...xyz) => new THREE.Vector3(...xyz);
export const translation = (xyz) => matrix().makeTranslation(...xyz);

// A pose by its rotation, row by row, and its origin.
export const poseOf = ([a, b, c, d, e, f, g, h, i], [x, y, z]) =>
  matrix().set(a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1);

export function createElement(tag, className, text) {
  const element = document.createElement(tag);
  if (className) element.className = className;
  if (text !== undefined) element.textContent = text;
  return element;
}

export function decodeBase64(text) {
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
}

// Resolves to the bytes (ArrayBuffer) of a text that is gzip in base64.
export function decompress(text) {
  const stream = new Blob([decodeBase64(text)]).stream()
    .pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

export function download(url, fileName) {
  const link = createElement("a");
  link.href = url;
  link.download = fileName;
  link.click();
}

// --- look-ups ---

export const bodyByName = new Map(data.mbs.bodies.map((body) => [body.name, body]));
// The joints of the .mbs by name: {joint, body}, and their numbers from 1 on.
export const jointByName = new Map();
export const jointNumbers = new Map();
for (const body of data.mbs.bodies) {
  for (const joint of body.joints) {
    jointByName.set(joint.name, {joint, body});
    jointNumbers.set(joint.name, jointNumbers.size + 1);
  }
}
// Of a URDF joint: the names of its coordinates, and of all joints of the .mbs that it became.
export const coordinatesOfJoint = new Map(data.coordinates);
export const mbsJointsOf = new Map(data.joints);
// Where the frame of each link is in the .mbs: {body, joint, pose}.
export const linkFrames = new Map(data.frames);
export const findBodyOfLink = (link) => linkFrames.has(link) ? linkFrames.get(link).body : undefined;
export const linksOfBody = new Map();
for (const [link, {body, joint}] of linkFrames) {
  if (joint === null) linksOfBody.set(body, [...(linksOfBody.get(body) || []), link]);
}
