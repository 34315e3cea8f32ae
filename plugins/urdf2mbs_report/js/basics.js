// The data of the page, its names, and small helpers.

// What report/page.py writes into the page; lengths are in m, angles in rad:
//   mbs: base {name, shapes}, bodies [{name, parent, at, joints, mass, com, inertia, shapes}]
//   urdf: root, links [{name, visuals, collisions}], joints [{name, type, parent, child, ...}]
//   frames, coordinates, joints: pairs of a URDF name and what it is in the .mbs
//   meshes: of each its parts, whose arrays are [place in bytes, length in words]; textures: urls
//   marks: points [body, xyz, kind, rotation], lines [kind, end, end], stops [joint, [low, high]]
//   motion: null, or what report/motion.py read
export const data = JSON.parse(document.getElementById("data").textContent);
export const byId = (id) => document.getElementById(id);
export const matrix = () => new THREE.Matrix4();
export const vector = (...xyz) => new THREE.Vector3(...xyz);
export const shift = (xyz) => matrix().makeTranslation(...xyz);
// the page of an .mbs alone has no URDF
export const alone = data.urdf.root === null;
// the size of the robot (m)
export const size = data.size;

export function element(tag, kind, text) {
  const made = document.createElement(tag);
  if (kind) made.className = kind;
  if (text !== undefined) made.textContent = text;
  return made;
}

// what the page holds in base64, and gzipped
export const bytesOf = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
export function unzip(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

export function save(url, name) {
  const link = element("a");
  link.href = url;
  link.download = name;
  link.click();
}

export const bodyOf = new Map(data.mbs.bodies.map((body) => [body.name, body]));
// of a joint of the .mbs: its body and itself, and its number
export const bodyOfJoint = new Map();
export const numbers = new Map();
for (const body of data.mbs.bodies) {
  for (const joint of body.joints) {
    bodyOfJoint.set(joint.name, [body, joint]);
    numbers.set(joint.name, numbers.size + 1);
  }
}
// of a URDF joint: the names of its coordinates, and of all joints that it became
export const coordinates = new Map(data.coordinates);
export const became = new Map(data.joints);
// where each link's frame is in the .mbs
export const frames = new Map(data.frames);
export const bodyOfLink = (link) => frames.has(link) ? frames.get(link).body : undefined;
export const linksOf = new Map();
for (const [link, at] of frames) {
  if (at.joint === null) linksOf.set(at.body, [...(linksOf.get(at.body) || []), link]);
}
