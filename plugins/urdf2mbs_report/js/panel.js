// The panel beside the 3D model: a slider for each joint, and the tree of links or bodies.

import {byId, createElement, data, isModelAlone, jointNumbers} from "./basics.js";
import {floatingCoordinates, followers, jointLimits, jointPositions, movingJoints,
  onPositionsChange, setPosition, updatePositions} from "./positions.js";
import {makeSelectable, selectJoint, showAxis} from "./selection.js";

const isInRadians = () => byId("unit").value === "rad";

// --- sliders ---

export function makeSliders() {
  // The base comes last: the robot's own joints are moved first.
  const isFloating = (joint) => floatingCoordinates.has(joint.name);
  const joints = [...movingJoints].sort((a, b) => isFloating(a) - isFloating(b));
  byId("sliders").append(...joints.map(makeSlider));
  if (!joints.length) {
    byId("sliders").append(createElement("p", "note", "No joint of this robot moves."));
  }
  byId("mimic-label").hidden = !followers.size;
  const setAll = (choosePosition) => () => {
    for (const joint of movingJoints) setPosition(joint.name, choosePosition(joint));
    updatePositions();
  };
  byId("zero").onclick = setAll(() => 0);
  byId("start").onclick = setAll((joint) => joint.q || 0);
  byId("random").onclick = setAll((joint) => {
    const [low, high] = jointLimits.get(joint.name);
    return isFloating(joint) ? jointPositions.get(joint.name) : low + (high - low) * Math.random();
  });
  byId("mimic").onchange = byId("unit").onchange = updatePositions;
  byId("filter-sliders").oninput = (event) =>
    filterRows([...byId("sliders").children, ...byId("tree").children], event.target.value);
}

function makeSlider(joint) {
  const [low, high] = jointLimits.get(joint.name);
  const unit = makeUnit(joint);
  const name = createElement("span", "name", joint.name);
  const range = createElement("input"), box = createElement("input");
  name.onclick = () => selectJoint(joint.name);
  Object.assign(range, {type: "range", min: low, max: high, step: "any"});
  Object.assign(box, {type: "number", step: "any"});
  range.setAttribute("aria-label", joint.name);
  box.setAttribute("aria-label", `value of ${joint.name}`);
  const move = (position) => {
    setPosition(joint.name, position);
    updatePositions();
    showAxis(joint);
  };
  range.addEventListener("input", () => {
    // The ends of a slider are the limits but for their last digits.
    const isNear = (limit) => Math.abs(range.value - limit) < 1e-9 * (high - low);
    const limit = [low, high].find(isNear);
    move(limit === undefined ? +range.value : limit);
  });
  box.addEventListener("change", () => move(+box.value / unit.factor()));

  const row = createElement("div", "slider"), top = createElement("div", "top");
  const ends = createElement("div", "ends");
  const [lowEnd, highEnd] = [createElement("span"), createElement("span")];
  const number = createElement("span", "q", `q${jointNumbers.get(joint.name)} ${joint.type}`);
  top.append(name, number, box);
  ends.append(lowEnd, highEnd);
  row.append(top, range, ends);
  row.dataset.joint = range.dataset.joint = joint.name;
  row.addEventListener("pointerenter", () => showAxis(joint));
  row.addEventListener("pointerleave", () => showAxis(null));
  range.addEventListener("focus", () => showAxis(joint));
  range.addEventListener("blur", () => showAxis(null));

  onPositionsChange(() => {
    const position = jointPositions.get(joint.name);
    range.value = position;
    box.value = unit.format(position);
    lowEnd.textContent = `${unit.format(low)}${unit.symbol()}`;
    highEnd.textContent = `${unit.format(high)}${unit.symbol()}`;
    const isFollower = byId("mimic").checked && followers.has(joint.name);
    range.disabled = box.disabled = isFollower;
    row.classList.toggle("follows", isFollower);
    name.title = isFollower ? `${joint.name} follows ${followers.get(joint.name)[0]}` : joint.name;
  });
  return row;
}

// The unit in which the positions of a joint are shown; the user may change it.
function makeUnit(joint) {
  const isRevolute = joint.type[0] === "R";
  const factor = () => {
    if (isInRadians()) return 1;
    return isRevolute ? 180 / Math.PI : 1000;
  };
  const symbol = () => {
    if (isInRadians()) return isRevolute ? " rad" : " m";
    return isRevolute ? "°" : " mm";
  };
  const format = (position) => `${+(position * factor()).toFixed(isInRadians() ? 4 : 1)}`;
  return {factor, symbol, format};
}

// Hide the rows that do not contain a text.
export function filterRows(rows, text) {
  for (const row of rows) row.hidden = !row.textContent.toLowerCase().includes(text.toLowerCase());
}

// --- the tree ---

// Make the tree of links, or of bodies where there is no URDF.
export function makeTree() {
  const children = new Map();
  for (const entry of isModelAlone ? listBodies() : listLinks()) {
    children.set(entry.parent, [...(children.get(entry.parent) || []), entry]);
  }
  const remaining = [{entry: {name: data.urdf.root, label: ""}, depth: 0}];
  while (remaining.length) {
    const {entry: {name, label}, depth} = remaining.pop();
    const row = createElement("div", "link", name === null ? data.mbs.base.name : name);
    row.style.paddingLeft = `${6 + 13 * Math.min(depth, 14)}px`;
    if (label) row.append(createElement("span", "q", ` ${label}`));
    row.dataset[isModelAlone ? "body" : "link"] = name || "";
    makeSelectable(row);
    byId("tree").append(row);
    for (const child of (children.get(name) || []).reverse()) {
      remaining.push({entry: child, depth: depth + 1});
    }
  }
  byId("as-links").onclick = () => showTree(true);
  byId("as-joints").onclick = () => showTree(false);
}

const listBodies = () => data.mbs.bodies.map(({name, parent, joints}) =>
  ({name, parent, label: joints.map((joint) => `${joint.type} ${joint.name}`).join(", ")}));

const listLinks = () => data.urdf.joints.map(({child, parent, type, name}) =>
  ({name: child, parent, label: `${type} ${name}`}));

function showTree(isTree) {
  byId("tree").hidden = !isTree;
  byId("sliders").hidden = isTree;
  byId("as-links").setAttribute("aria-pressed", isTree);
  byId("as-joints").setAttribute("aria-pressed", !isTree);
}
