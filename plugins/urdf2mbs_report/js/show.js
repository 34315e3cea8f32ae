// What is seen: switches, what differs in red and blue, and the line that says so.

import {alone, bodyOfLink, byId, element} from "./basics.js";
import {chosen} from "./choose.js";
import {differs, evaluate, now} from "./compare.js";
import {bones, moveMarks} from "./marks.js";
import {grid, holders, kinds, redraw, sides} from "./scene.js";
import {drawn} from "./shapes.js";

const TINT = {mbs: new THREE.Color(0xd6273b), urdf: new THREE.Color(0x1f5fe0)};
let blinking = false, ready = false;

export function update() {
  evaluate();
  if (ready) {
    for (const [name, group] of holders.mbs) group.matrix.copy(now.mbs.bodies.get(name));
    for (const [name, group] of holders.urdf) group.matrix.copy(now.links.get(name));
    moveMarks(now.mbs);
  }
  show();
}

// all is built
export function begin() {
  ready = true;
  if (!drawn.length) byId("show-skeleton").checked = true;
  update();
  setInterval(() => drawn.some(differs) && blink(), 600);
}

export function blink() {
  blinking = !blinking;
  show();
}

const on = (id) => byId(id) && byId(id).checked;

export function show() {
  const side = alone ? "mbs" : document.querySelector("input[name=side]:checked").value;
  sides.mbs.visible = side !== "urdf";
  sides.urdf.visible = side !== "mbs";
  for (const kind of Object.keys(kinds)) {
    for (const object of kinds[kind]) object.visible = on(`show-${kind}`);
  }
  for (const [one, object] of bones) {
    // where both agree, one skeleton is enough
    object.visible = object.visible && (side === one || one === "mbs" || now.differing.size > 0);
  }
  grid.visible = on("show-grid");
  for (const one of drawn) {
    const off = side === "both" && differs(one);
    if (off && on("show-shapes")) one.group.visible = blinking === (one.side === "mbs");
    else if (side === "both" && one.twin) one.group.visible = false;  // where both agree, one is enough
    for (const object of one.objects) tint(object.material, one, off);
  }
  if (!alone) tellAgreement();
  redraw();
}

function tint(m, one, off) {
  const own = m.userData.own || (m.userData.own = {color: m.color.clone(), opacity: m.opacity});
  m.opacity = (on("see-through") ? 0.35 : 1) * own.opacity;
  m.depthWrite = m.opacity > 0.5;
  if (m.transparent !== m.opacity < 1) {
    m.transparent = m.opacity < 1;
    m.needsUpdate = true;
  }
  m.color.copy(off ? TINT[one.side] : own.color);
  m.emissive.set(chosen.body !== undefined && bodyOfDrawn(one) === chosen.body ? 0x6a4a00 : 0x000000);
}

export const bodyOfDrawn = (one) => one.side === "mbs" ? one.owner : bodyOfLink(one.owner);

const some = (names) => names.slice(0, 6).join(", ")
  + (names.length > 6 ? ` and ${names.length - 6} more` : "");

function tellAgreement() {
  const wrong = drawn.filter((one) => one.differs), {differing, compared, farthest, shapes} = now;
  const places = differing.size ? `${differing.size} of ${compared} link frames are elsewhere or turned `
    + `(${some([...differing])}), by up to ${+farthest.toPrecision(3)} m. ` : "";
  const forms = ["in form or place", "in colour"].map((how) => {
    const which = [...new Set(wrong.filter((one) => one.differs === how).map((one) => one.about))];
    return which.length ? `Shapes differ ${how}: ${some(which)}. ` : "";
  });
  const alike = `URDF and .mbs agree here: ${compared} link frames${
    ready && shapes ? ` and ${shapes} shapes` : ""}, apart by at most ${farthest.toExponential(1)} m`;
  const text = places + forms.join("");
  byId("agreement").replaceChildren(element("span", text ? "no" : "yes", text || alike));
}
