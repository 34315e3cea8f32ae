// The panel beside the 3D model: a slider for each joint, and the tree of links or bodies.

import {alone, byId, data, element, numbers} from "./basics.js";
import {chooseJoint, makeChoosable, point} from "./choose.js";
import {floating, follows, limits, moving, onChange, q, set, settle} from "./positions.js";

const inRadians = () => byId("unit").value === "rad";

function makeSlider(joint) {
  const turns = joint.type[0] === "R", [low, high] = limits.get(joint.name);
  const row = element("div", "slider"), top = element("div", "top"), ends = element("div", "ends");
  const name = element("span", "name", joint.name), range = element("input"), box = element("input");
  name.onclick = () => chooseJoint(joint.name);
  Object.assign(range, {type: "range", min: low, max: high, step: "any"});
  Object.assign(box, {type: "number", step: "any"});
  range.setAttribute("aria-label", joint.name);
  box.setAttribute("aria-label", `value of ${joint.name}`);
  row.dataset.joint = range.dataset.joint = joint.name;
  const factor = () => inRadians() ? 1 : turns ? 180 / Math.PI : 1000;
  const unit = () => inRadians() ? turns ? " rad" : " m" : turns ? "°" : " mm";
  const word = (value) => `${+(value * factor()).toFixed(inRadians() ? 4 : 1)}`;
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
  const [least, most] = [element("span"), element("span")];
  top.append(name, element("span", "q", `q${numbers.get(joint.name)} ${joint.type}`), box);
  ends.append(least, most);
  row.append(top, range, ends);
  onChange(() => {
    range.value = q.get(joint.name);
    box.value = word(q.get(joint.name));
    least.textContent = `${word(low)}${unit()}`;
    most.textContent = `${word(high)}${unit()}`;
    const led = byId("mimic").checked && follows.has(joint.name);
    range.disabled = box.disabled = led;
    row.classList.toggle("follows", led);
    name.title = led ? `${joint.name} follows ${follows.get(joint.name)[0]}` : joint.name;
  });
  return row;
}

export function makeSliders() {
  // the base comes last: one moves the robot's own joints first
  const sorted = [...moving].sort((a, b) => floating.has(a.name) - floating.has(b.name));
  byId("sliders").append(...sorted.map(makeSlider));
  if (!moving.length) byId("sliders").append(element("p", "note", "No joint of this robot moves."));
  byId("mimic-label").hidden = !follows.size;
  const all = (value) => () => {
    for (const joint of moving) set(joint.name, value(joint));
    settle();
  };
  byId("zero").onclick = all(() => 0);
  byId("start").onclick = all((joint) => joint.q || 0);
  byId("random").onclick = all(({name}) => {
    const [low, high] = limits.get(name);
    return floating.has(name) ? q.get(name) : low + (high - low) * Math.random();
  });
  byId("mimic").onchange = byId("unit").onchange = settle;
  byId("filter-sliders").oninput = (event) =>
    filterRows([...byId("sliders").children, ...byId("tree").children], event.target.value);
}

export function filterRows(rows, text) {
  for (const row of rows) row.hidden = !row.textContent.toLowerCase().includes(text.toLowerCase());
}

// the tree of links, or of bodies where there is no URDF
export function makeTree() {
  const below = new Map();
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
    byId("tree").append(row);
    for (const next of (below.get(name) || []).reverse()) todo.push([next, depth + 1]);
  }
  const turn = (links) => {
    byId("tree").hidden = !links;
    byId("sliders").hidden = links;
    byId("as-links").setAttribute("aria-pressed", links);
    byId("as-joints").setAttribute("aria-pressed", !links);
  };
  byId("as-links").onclick = () => turn(true);
  byId("as-joints").onclick = () => turn(false);
}
