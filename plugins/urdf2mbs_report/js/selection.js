// The selection of a body or a joint: it is marked in the 3D model, the diagram and the tables.

import {bodyByName, byId, createElement, data, findBodyOfLink, isModelAlone, jointByName,
  jointNumbers, linksOfBody, mbsJointsOf, robotSize, vector} from "./basics.js";
import {comparison} from "./comparison.js";
import {jointLimits} from "./positions.js";
import {camera, renderer, requestDrawing, scene, sideGroups} from "./scene.js";
import {drawnShapes, findBodyOfShape} from "./shapes.js";

// The name of a body, null for the base, undefined for nothing; and of one of the body's joints.
export const selection = {body: undefined, joint: undefined};

export function select(body, joint) {
  Object.assign(selection, {body, joint});
  describeSelection();
  for (const element of document.querySelectorAll(".selected")) markSelected(element, false);
  const selectable = "[data-body]:not(.point), [data-link], [data-joint]:not(input), [data-urdf-joint]";
  for (const element of document.querySelectorAll(selectable)) {
    if (body !== undefined && isSelected(element)) markSelected(element, true);
  }
  showAxis(null);
  for (const listener of selectionListeners) listener();
}

function markSelected(element, isOn) {
  element.classList.toggle("selected", isOn);
  if (element.ariaSelected !== null) element.ariaSelected = isOn;
}

const selectionListeners = [];
// The listener is called after each change of the selection.
export const onSelectionChange = (listener) => selectionListeners.push(listener);

export const selectJoint = (name) => select(jointByName.get(name).body.name, name);

// True if a row, an entry of the tree, a slider or a part of the diagram is of the selection.
function isSelected({dataset: {body, link, joint, urdfJoint}}) {
  if (body !== undefined) return body === (selection.body || "");
  if (link !== undefined) return findBodyOfLink(link) === selection.body;
  const names = joint !== undefined ? [joint] : mbsJointsOf.get(urdfJoint) || [];
  return names.some((name) => selection.joint === undefined
    ? jointByName.get(name).body.name === selection.body : name === selection.joint);
}

// Describe the selection in the corner of the 3D model.
function describeSelection() {
  const panel = byId("picked"), body = bodyByName.get(selection.body);
  panel.textContent = selection.body === null ? `base: ${data.mbs.base.name}` : "";
  if (!body) return;
  const describeJoint = ({name, type}) => `q${jointNumbers.get(name)} ${type} ${name}`;
  const lines = [""];
  if (selection.joint !== undefined) {
    const {joint} = jointByName.get(selection.joint);
    lines.push(`joint: ${describeJoint(joint)}, ${joint.nature}`);
  }
  if (!isModelAlone) lines.push(`links: ${listAtMostEight(linksOfBody.get(body.name) || [], ",")}`);
  lines.push(`mass: ${body.mass === null ? "none" : `${+body.mass.toPrecision(6)} kg`}`);
  if (selection.joint === undefined) {
    lines.push(`joints: ${listAtMostEight(body.joints.map(describeJoint), ";")}`);
  }
  panel.append(createElement("b", "", body.name), lines.join("\n"));
}

const listAtMostEight = (words, separator) =>
  words.slice(0, 8).join(`${separator} `) + (words.length > 8 ? `${separator} ...` : "");

// --- by the mouse ---

// The ray from the camera through the mouse.
export function castRay(event) {
  const box = renderer.domElement.getBoundingClientRect(), raycaster = new THREE.Raycaster();
  raycaster.setFromCamera({
    x: 2 * (event.clientX - box.left) / box.width - 1,
    y: 1 - 2 * (event.clientY - box.top) / box.height,
  }, camera);
  return raycaster;
}

// The body that is under the mouse, and the point that is hit (m).
export function findBodyAt(event) {
  const objects = drawnShapes.filter((shape) => shape.group.visible && sideGroups[shape.side].visible)
    .flatMap((shape) => shape.meshes);
  const [hit] = castRay(event).intersectObjects(objects);
  return hit && {body: findBodyOfShape(hit.object.userData.shape), point: hit.point};
}

export function selectAt(event) {
  const hit = findBodyAt(event);
  select(hit && hit.body);
}

// Select the body or joint of an element: of a row, an entry of the tree, or a part of the diagram.
export function selectElement({dataset: {joint, urdfJoint, body, link}}) {
  const names = mbsJointsOf.get(urdfJoint) || [];
  // Of the joints that a URDF joint became, the one that moves.
  const movingJoint = names.find((name) => jointLimits.has(name)) || names[0];
  const name = joint !== undefined ? joint : movingJoint;
  if (name !== undefined) selectJoint(name);
  else if (body !== undefined) select(body || null);
  else if (link !== undefined) select(findBodyOfLink(link));
}

// Let a click, Enter or a space select the body or joint of an element; see makeRoving for the keys
// that lead to it.
export function makeSelectable(element) {
  element.tabIndex = -1;
  element.ariaSelected = "false";
  element.classList.add("selectable");
  element.addEventListener("click", () => selectElement(element));
  element.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    selectElement(element);
  });
}

// --- the axis of a joint ---

let axisArrow = null;

// Show the axis of a joint; with null, that of the selected joint.
export function showAxis(joint) {
  if (axisArrow) scene.remove(axisArrow);
  axisArrow = null;
  if (!joint && selection.joint !== undefined) joint = jointByName.get(selection.joint).joint;
  if (joint && comparison.mbs) {
    const pose = comparison.mbs.joints.get(joint.name);
    const direction = vector().setFromMatrixColumn(pose, +joint.type[1] - 1);
    axisArrow = new THREE.ArrowHelper(direction, vector().setFromMatrixPosition(pose),
      robotSize * 0.22, 0xd6273b, robotSize * 0.05, robotSize * 0.025);
    for (const part of [axisArrow.line, axisArrow.cone]) {
      part.material.depthTest = false;
      part.material.transparent = true;
      part.renderOrder = 9;
    }
    scene.add(axisArrow);
  }
  requestDrawing();
}
