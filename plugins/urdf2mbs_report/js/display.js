// The display: switches, differences in red and blue, and the line that tells of them.

import {byId, isModelAlone} from "./basics.js";
import {comparePoses, comparison, isDifferent} from "./comparison.js";
import {MAX_GAP, cuts, measureGap} from "./loops.js";
import {moveLoopLines, showContacts} from "./marks.js";
import {grid, groups, objectsByKind, requestDrawing, sideGroups} from "./scene.js";
import {selection} from "./selection.js";
import {drawnShapes, findBodyOfShape} from "./shapes.js";
import {bones} from "./skeleton.js";
import {moveStops} from "./stops.js";

const ROUNDING = 1e-12;  // m: what is apart by less is in one place

const DIFFERENCE_COLORS = {mbs: new THREE.Color(0xd6273b), urdf: new THREE.Color(0x1f5fe0)};
const SELECTION_GLOW = 0x6a4a00;
const BLINK_PERIOD = 600;  // ms
// Who wants less motion sees both sides of a difference at once, and nothing blinks.
const isStill = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
let showsMbsOfDifferences = false, isBuilt = false;

// Move all to the current positions.
export function updateScene() {
  comparePoses();
  if (isBuilt) {
    const {bodies, joints} = comparison.mbs;
    for (const [name, group] of groups.mbs) group.matrix.copy(bodies.get(name));
    for (const [name, group] of groups.urdf) group.matrix.copy(comparison.links.get(name));
    moveLoopLines(bodies);
    moveStops(joints);
  }
  updateDisplay();
}

// Begin when all is built.
export function startDisplay() {
  isBuilt = true;
  if (!drawnShapes.length) byId("show-skeleton").checked = true;
  updateScene();
  if (!isStill) setInterval(() => drawnShapes.some(isDifferent) && blink(), BLINK_PERIOD);
}

// Of shapes that differ, show those of the other side.
export function blink() {
  showsMbsOfDifferences = !showsMbsOfDifferences;
  updateDisplay();
}

const isChecked = (id) => byId(id) && byId(id).checked;

// Show and colour all as the switches, the comparison and the selection say.
export function updateDisplay() {
  const side = isModelAlone ? "mbs" : document.querySelector("input[name=side]:checked").value;
  sideGroups.mbs.visible = side !== "urdf";
  sideGroups.urdf.visible = side !== "mbs";
  for (const [kind, objects] of Object.entries(objectsByKind)) {
    for (const object of objects) object.visible = isChecked(`show-${kind}`);
  }
  showContacts(isChecked("show-contacts"), selection.body, comparison.mbs.bodies);
  for (const bone of bones) {
    // Where both sides agree, one skeleton is enough.
    const isNeeded = side === bone.side || bone.side === "mbs" || comparison.differingLinks.size > 0;
    bone.object.visible = bone.object.visible && isNeeded;
  }
  grid.visible = isChecked("show-grid");
  for (const shape of drawnShapes) {
    const isMarked = side === "both" && isDifferent(shape);
    if (isMarked && isChecked("show-shapes")) {
      shape.group.visible = isStill || showsMbsOfDifferences === (shape.side === "mbs");
    } else if (side === "both" && shape.counterpart) {
      shape.group.visible = false;  // where both sides agree, one shape is enough
    }
    for (const object of shape.meshes) colorMaterial(object.material, shape, isMarked);
  }
  if (!isModelAlone) showAgreement();
  showGap();
  requestDrawing();
}

function colorMaterial(material, shape, isMarked) {
  if (!material.userData.original) {
    material.userData.original = {color: material.color.clone(), opacity: material.opacity};
  }
  const {color, opacity} = material.userData.original;
  const isSeenThrough = isChecked("see-through") || isMarked && isStill;
  material.opacity = (isSeenThrough ? 0.35 : 1) * opacity;
  material.depthWrite = material.opacity > 0.5;
  if (material.transparent !== material.opacity < 1) {
    material.transparent = material.opacity < 1;
    material.needsUpdate = true;
  }
  material.color.copy(isMarked ? DIFFERENCE_COLORS[shape.side] : color);
  const isSelected = selection.body !== undefined && findBodyOfShape(shape) === selection.body;
  material.emissive.set(isSelected ? SELECTION_GLOW : 0x000000);
}

const listSome = (names) => names.slice(0, 6).join(", ")
  + (names.length > 6 ? ` and ${names.length - 6} more` : "");

function showAgreement() {
  const {differingLinks, comparedLinks, largestDistance, equalShapes} = comparison;
  const sentences = [];
  if (differingLinks.size) {
    sentences.push(`${differingLinks.size} of ${comparedLinks} link frames are elsewhere or turned `
      + `(${listSome([...differingLinks])}), by up to ${+largestDistance.toPrecision(3)} m. `);
  }
  for (const difference of ["in form or place", "in colour"]) {
    const labels = new Set(drawnShapes.filter((shape) => shape.difference === difference)
      .map((shape) => shape.label));
    if (labels.size) sentences.push(`Shapes differ ${difference}: ${listSome([...labels])}. `);
  }
  const shapes = isBuilt && equalShapes ? ` and ${equalShapes} shapes` : "";
  const agreement = `URDF and .mbs agree here: ${comparedLinks} link frames${shapes}, apart by at `
    + `most ${largestDistance < ROUNDING ? 0 : largestDistance.toExponential(1)} m`;
  const text = sentences.join("");
  byId("agreement").className = text ? "no" : "yes";
  byId("agreement").textContent = text || agreement;
}

// The loops, each with its gap (m).
export const measureGaps = () =>
  cuts.map((cut) => ({name: cut.name, gap: measureGap(cut, comparison.mbs)}));

// Say which loop is open the most, if one is.
function showGap() {
  const open = measureGaps().filter(({gap}) => gap > MAX_GAP).sort((a, b) => b.gap - a.gap);
  const others = open.length > 1 ? `, ${open.length - 1} more by less` : "";
  byId("gap").hidden = !open.length;
  if (open.length) {
    const length = +(1000 * open[0].gap).toPrecision(3);
    byId("gap").textContent = `Loop '${open[0].name}' is open by ${length} mm here${others}`;
  }
}
