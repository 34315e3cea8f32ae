// Choosing a body or a joint: it is marked in the 3D model, the diagram and the tables alike.

import {alone, became, bodyOf, bodyOfJoint, bodyOfLink, byId, data, element, linksOf, numbers, size,
  vector} from "./basics.js";
import {now} from "./compare.js";
import {q} from "./positions.js";
import {camera, redraw, renderer, scene, sides} from "./scene.js";
import {drawn} from "./shapes.js";
import {bodyOfDrawn, show} from "./show.js";

// the name of a body, null for the base, undefined for nothing; and of one of the body's joints
export const chosen = {body: undefined, joint: undefined};

export function choose(body, joint) {
  Object.assign(chosen, {body, joint});
  tell();
  for (const one of document.querySelectorAll(".chosen")) one.classList.remove("chosen");
  const marked = "[data-body]:not(.point), [data-link], [data-joint]:not(input), [data-urdf-joint]";
  for (const one of document.querySelectorAll(marked)) {
    if (body !== undefined && isChosen(one.dataset)) one.classList.add("chosen");
  }
  point(null);
  show();
}
export const chooseJoint = (name) => choose(bodyOfJoint.get(name)[0].name, name);

function isChosen({body, link, joint, urdfJoint}) {
  if (body !== undefined) return body === (chosen.body || "");
  if (link !== undefined) return bodyOfLink(link) === chosen.body;
  const names = joint !== undefined ? [joint] : became.get(urdfJoint) || [];
  return names.some((name) => chosen.joint === undefined
    ? bodyOfJoint.get(name)[0].name === chosen.body : name === chosen.joint);
}

// a list with at most eight entries
const atMostEight = (words, sign) => words.slice(0, 8).join(`${sign} `) + (words.length > 8 ? `${sign} ...` : "");

// say what is chosen, in the corner of the 3D model
function tell() {
  const about = byId("picked"), body = bodyOf.get(chosen.body);
  about.textContent = chosen.body === null ? `base: ${data.mbs.base.name}` : "";
  if (!body) return;
  const told = ({name, type}) => `q${numbers.get(name)} ${type} ${name}`;
  const lines = [""];
  if (chosen.joint !== undefined) {
    const joint = bodyOfJoint.get(chosen.joint)[1];
    lines.push(`joint: ${told(joint)}, ${joint.nature}`);
  }
  if (!alone) lines.push(`links: ${atMostEight(linksOf.get(body.name) || [], ",")}`);
  lines.push(`mass: ${body.mass === null ? "none" : `${+body.mass.toPrecision(6)} kg`}`);
  if (chosen.joint === undefined) lines.push(`joints: ${atMostEight(body.joints.map(told), ";")}`);
  about.append(element("b", "", body.name), lines.join("\n"));
}

// the ray from the camera through the mouse
export function rayThrough(event) {
  const box = renderer.domElement.getBoundingClientRect(), ray = new THREE.Raycaster();
  ray.setFromCamera({
    x: 2 * (event.clientX - box.left) / box.width - 1,
    y: 1 - 2 * (event.clientY - box.top) / box.height,
  }, camera);
  return ray;
}

// the body that is under the mouse, and where (m)
export function hitBody(event) {
  const targets = drawn.filter((one) => one.group.visible && sides[one.side].visible)
    .flatMap((one) => one.objects);
  const [hit] = rayThrough(event).intersectObjects(targets);
  return hit && {body: bodyOfDrawn(hit.object.userData.drawn), point: hit.point};
}

export function pick(event) {
  const hit = hitBody(event);
  choose(hit && hit.body);
}

// choose what a row of a table, an entry of the tree or a slider stands for
export function chooseWhat({dataset: {joint, urdfJoint, body, link}}) {
  const names = became.get(urdfJoint) || [];
  // of the joints that a URDF joint became, the one that moves
  const real = joint !== undefined ? joint : names.find((name) => q.has(name)) || names[0];
  if (real !== undefined) chooseJoint(real);
  else if (body !== undefined) choose(body || null);
  else if (link !== undefined) choose(bodyOfLink(link));
}

export function makeChoosable(row) {
  row.tabIndex = 0;
  row.classList.add("choosable");
  row.addEventListener("click", () => chooseWhat(row));
  row.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    chooseWhat(row);
  });
}

// show the axis of a joint; of none, the axis of the joint that is chosen
let arrow = null;
export function point(joint) {
  if (arrow) scene.remove(arrow);
  arrow = null;
  joint = joint || (chosen.joint === undefined ? null : bodyOfJoint.get(chosen.joint)[1]);
  if (joint && now.mbs) {
    const pose = now.mbs.joints.get(joint.name);
    const along = vector().setFromMatrixColumn(pose, +joint.type[1] - 1);
    arrow = new THREE.ArrowHelper(along, vector().setFromMatrixPosition(pose),
      size * 0.22, 0xd6273b, size * 0.05, size * 0.025);
    for (const part of [arrow.line, arrow.cone]) {
      part.material.depthTest = false;
      part.material.transparent = true;
      part.renderOrder = 9;
    }
    scene.add(arrow);
  }
  redraw();
}
