// The panel beside the 3D model: a slider for each joint, and the tree of links or bodies.

import {byId, createElement, data, isModelAlone, jointNumbers} from "./basics.js";
import {baseJoints, followers, isFollower, jointLimits, jointPositions, moveAll, movePositions,
  movingJoints, onPositionsChange, showStart, updatePositions} from "./positions.js";
import {makeRoving} from "./roving.js";
import {makeSelectable, selectJoint, showAxis} from "./selection.js";
import {formatPosition, formatWithUnit, getUnit, onUnitChange} from "./units.js";

// --- sliders ---

export function makeSliders() {
  // The base comes last: the robot's own joints are moved first.
  const isOfBase = (joint) => baseJoints.has(joint.name);
  const joints = [...movingJoints].sort((a, b) => isOfBase(a) - isOfBase(b));
  byId("sliders").append(...joints.map(makeSlider));
  if (!joints.length) {
    byId("sliders").append(createElement("p", "note", "No joint of this robot moves."));
  }
  byId("mimic-label").hidden = !followers.size;
  byId("zero").onclick = () => moveAll(() => 0);
  byId("start").onclick = showStart;
  byId("random").onclick = () => moveAll((joint) => {
    const [low, high] = jointLimits.get(joint.name);
    return low + (high - low) * Math.random();
  });
  byId("mimic").onchange = updatePositions;
}

const FOLDED_SLIDERS = 8, FOLDED_LINKS = 22;  // as in page.css

// Let the panel show as many rows as fit beside the robot, or all.
function makeFold(refresh) {
  const panel = byId("panel"), button = byId("unfold");
  const show = () => {
    const isTree = byId("sliders").hidden, list = isTree ? byId("tree") : byId("sliders");
    const count = list.children.length, isLong = count > (isTree ? FOLDED_LINKS : FOLDED_SLIDERS);
    const rows = isTree ? byId("as-links").textContent.toLowerCase() : "joints";
    button.hidden = !isLong || byId("filter-sliders").value !== "";
    button.textContent = panel.classList.contains("folded") ? `Show all ${count} ${rows}` : "Show fewer";
    refresh();
  };
  const fold = (isFolded) => { panel.classList.toggle("folded", isFolded); show(); };
  button.onclick = () => fold(!panel.classList.contains("folded"));
  fold(true);
  return {fold, show};
}

// A panel that takes the whole width, as on a phone, is folded at first.
export function foldPanel() {
  if (window.matchMedia("(max-width: 900px)").matches) byId("panel").open = false;
}

// Make the keys and the filter of the panel, which has all sliders and the tree.
export function makePanelControls() {
  for (const group of document.querySelectorAll(".tabs")) makeRoving(group, "button");
  makeRoving(document.querySelector(".choices"), "input, button");
  // Of the sliders, Tab stops at those of the joint whose name was last in focus.
  const refreshSliders = makeRoving(byId("sliders"), ".slider .name", (name) => {
    for (const input of byId("sliders").querySelectorAll("input")) {
      input.tabIndex = input.closest(".slider").contains(name) ? 0 : -1;
    }
  });
  byId("sliders").addEventListener("focusin", (event) => {
    const row = event.target.closest(".slider");
    if (row && event.target.tagName === "INPUT" && event.target.tabIndex < 0) {
      row.querySelector(".name").dispatchEvent(new FocusEvent("focusin", {bubbles: true}));
    }
  });
  const refreshTree = makeRoving(byId("tree"), "[role=treeitem]");
  const {fold, show} = makeFold(() => { refreshSliders(); refreshTree(); });
  byId("filter-sliders").oninput = (event) => {
    filterRows([...byId("sliders").children, ...byId("tree").children], event.target.value);
    fold(event.target.value === "");
  };
  byId("as-links").onclick = () => { showTree(true); show(); };
  byId("as-joints").onclick = () => { showTree(false); show(); };
}

function makeSlider(joint) {
  const [low, high] = jointLimits.get(joint.name);
  const name = createElement("button", "name", joint.name);
  const range = createElement("input"), box = createElement("input");
  name.onclick = () => selectJoint(joint.name);
  Object.assign(range, {type: "range", min: low, max: high, step: "any"});
  Object.assign(box, {type: "number", step: "any"});
  range.setAttribute("aria-label", joint.name);
  box.setAttribute("aria-label", `value of ${joint.name}`);
  const move = (position) => {
    movePositions(new Map([[joint.name, Math.min(Math.max(position, low), high)]]));
    showAxis(joint);
  };
  range.addEventListener("input", () => {
    // The ends of a slider are the limits but for their last digits.
    const isNear = (limit) => Math.abs(range.value - limit) < 1e-9 * (high - low);
    const limit = [low, high].find(isNear);
    move(limit === undefined ? +range.value : limit);
  });
  box.addEventListener("change", () => move(+box.value / getUnit(joint.type).factor));

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

  const show = () => {
    const position = jointPositions.get(joint.name);
    range.value = position;
    range.setAttribute("aria-valuetext", formatWithUnit(joint.type, position));
    box.value = formatPosition(joint.type, position);
    lowEnd.textContent = formatWithUnit(joint.type, low);
    highEnd.textContent = formatWithUnit(joint.type, high);
    range.disabled = box.disabled = isFollower(joint.name);
    row.classList.toggle("follows", isFollower(joint.name));
    name.title = isFollower(joint.name) ? `${joint.name} follows ${followers.get(joint.name)[0]}`
      : joint.name;
  };
  onPositionsChange(show);
  onUnitChange(show);
  return row;
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
    row.role = "treeitem";
    row.ariaLevel = depth + 1;
    row.style.paddingLeft = `${6 + 13 * Math.min(depth, 14)}px`;
    if (label) row.append(createElement("span", "q", ` ${label}`));
    row.dataset[isModelAlone ? "body" : "link"] = name || "";
    makeSelectable(row);
    byId("tree").append(row);
    for (const child of (children.get(name) || []).reverse()) {
      remaining.push({entry: child, depth: depth + 1});
    }
  }
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
