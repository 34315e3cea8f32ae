// The diagram: moved by dragging or two fingers, and zoomed by Ctrl and the wheel or by two fingers.

import {byId, data, download} from "./basics.js";
import {onTwoFingers, onZoomingWheel} from "./gestures.js";
import {select, selectElement} from "./selection.js";

const MAX_ZOOM = 20;  // how much smaller than the diagram the part that is seen may be
const KEY_STEP = 0.1;  // of the part that is seen

export function makeDiagram() {
  const svg = document.querySelector("#paper > svg");
  if (!svg) return;
  const {x, y, width, height} = svg.viewBox.baseVal;
  const sheet = makeSheet(svg, [x, y, width, height]);
  svg.removeAttribute("width");
  svg.removeAttribute("height");
  Object.assign(svg, {tabIndex: 0, role: "application"});
  svg.ariaLabel = "The diagram: arrow keys move it, + and - zoom, Home shows all of it";
  // The frame has the shape of the diagram, and fits into the window.
  Object.assign(byId("paper").style,
    {aspectRatio: `${width} / ${height}`, maxWidth: `calc(84vh * ${width / height})`});
  byId("diagram-fit").onclick = sheet.fit;
  byId("diagram-full").onclick = () => sheet.show([x, y, svg.clientWidth, svg.clientHeight]);
  byId("diagram-save").onclick = () => saveDiagram(svg, [x, y, width, height]);
  onZoomingWheel(svg, (event) => {
    const zoom = Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.003);
    sheet.zoomAt([event.clientX, event.clientY], zoom);
  });
  onTwoFingers(svg, ({from, to, factor}) => {
    sheet.move(to[0] - from[0], to[1] - from[1]);
    sheet.zoomAt(to, 1 / factor);
  });
  svg.addEventListener("keydown", (event) => moveSheetByKey(event, svg, sheet));
  letMouseDrag(svg, sheet);
  // All of the diagram is printed.
  let boxBeforePrint = null;
  window.addEventListener("beforeprint", () => { boxBeforePrint = sheet.box(); sheet.fit(); });
  window.addEventListener("afterprint", () => sheet.show(boxBeforePrint));
}

// The part of the diagram that is seen, [x, y, width, height] in px of the diagram, and how it moves.
function makeSheet(svg, wholeBox) {
  let viewBox = wholeBox;
  const show = (box) => {
    viewBox = box;
    svg.setAttribute("viewBox", box.join(" "));
  };
  // Its middle stays on the diagram.
  const showWithin = ([left, top, width, height]) => {
    const clamp = (corner, size, axis) => Math.min(Math.max(corner, wholeBox[axis] - size / 2),
      wholeBox[axis] + wholeBox[axis + 2] - size / 2);
    show([clamp(left, width, 0), clamp(top, height, 1), width, height]);
  };
  // Pixels of the diagram in a pixel of the screen.
  const computeScale = () => Math.max(viewBox[2] / svg.clientWidth, viewBox[3] / svg.clientHeight);
  const move = (dx, dy) => {
    const scale = computeScale();
    showWithin([viewBox[0] - dx * scale, viewBox[1] - dy * scale, viewBox[2], viewBox[3]]);
  };
  // Show more (zoom > 1) or less; the point under the mouse stays where it is.
  const zoomAt = ([clientX, clientY], zoom) => {
    const area = svg.getBoundingClientRect(), scale = computeScale();
    const [left, top, width, height] = viewBox;
    const size = Math.min(Math.max(width * zoom, wholeBox[2] / MAX_ZOOM), 2 * wholeBox[2]);
    const factor = size / width;
    const mouseX = left + width / 2 + (clientX - area.left - area.width / 2) * scale;
    const mouseY = top + height / 2 + (clientY - area.top - area.height / 2) * scale;
    showWithin([mouseX - (mouseX - left) * factor, mouseY - (mouseY - top) * factor,
      width * factor, height * factor]);
  };
  return {box: () => viewBox, fit: () => show(wholeBox), show, move, zoomAt};
}

function moveSheetByKey(event, svg, sheet) {
  const area = svg.getBoundingClientRect();
  const middle = [area.left + area.width / 2, area.top + area.height / 2];
  const [dx, dy] = {ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[
    event.key] || [0, 0];
  const zoom = {"+": 0.8, "-": 1.25}[event.key];
  if (event.key === "Home") sheet.fit();
  else if (zoom) sheet.zoomAt(middle, zoom);
  else if (dx || dy) sheet.move(dx * KEY_STEP * area.width, dy * KEY_STEP * area.height);
  else return;
  event.preventDefault();
}

// A finger scrolls the page; a mouse drags, and a click selects.
function letMouseDrag(svg, sheet) {
  let lastEvent = null, movedPixels = 0;
  svg.addEventListener("pointerdown", (event) => {
    movedPixels = 0;
    if (event.pointerType !== "touch") lastEvent = event;
  });
  window.addEventListener("pointermove", (event) => {
    if (!lastEvent) return;
    const dx = event.clientX - lastEvent.clientX, dy = event.clientY - lastEvent.clientY;
    movedPixels += Math.abs(dx) + Math.abs(dy);
    sheet.move(dx, dy);
    lastEvent = event;
  });
  window.addEventListener("pointerup", () => { lastEvent = null; });
  svg.addEventListener("click", (event) => {
    if (movedPixels >= 4) return;  // it was a drag
    const element = event.target.closest("[data-joint], [data-body]");
    if (element) selectElement(element);
    else select(undefined);
  });
}

function saveDiagram(svg, wholeBox) {
  const copy = svg.cloneNode(true);
  copy.setAttribute("viewBox", wholeBox.join(" "));
  copy.setAttribute("width", wholeBox[2]);
  copy.setAttribute("height", wholeBox[3]);
  const text = new XMLSerializer().serializeToString(copy);
  download(URL.createObjectURL(new Blob([text], {type: "image/svg+xml"})), `${data.name}.svg`);
}
