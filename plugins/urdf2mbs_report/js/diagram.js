// The diagram, moved by dragging and zoomed by the wheel, and the filters of tables.

import {byId, data, download} from "./basics.js";
import {filterRows} from "./panel.js";
import {makeSelectable, select, selectElement} from "./selection.js";

export function makeDiagram() {
  const svg = byId("paper").querySelector("svg");
  if (!svg) return;
  const {x, y, width, height} = svg.viewBox.baseVal;
  // The part of the diagram that is seen: [x, y, width, height] (px).
  const wholeBox = [x, y, width, height];
  let viewBox = wholeBox;
  const setViewBox = (box) => {
    viewBox = box;
    svg.setAttribute("viewBox", box.join(" "));
  };
  // Pixels of the diagram in a pixel of the screen.
  const computeScale = () =>
    Math.max(viewBox[2] / svg.clientWidth, viewBox[3] / svg.clientHeight);
  svg.removeAttribute("width");
  svg.removeAttribute("height");
  byId("diagram-fit").onclick = () => setViewBox(wholeBox);
  byId("diagram-full").onclick = () => setViewBox([x, y, svg.clientWidth, svg.clientHeight]);
  byId("diagram-save").onclick = () => saveDiagram(svg, wholeBox);

  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    const area = svg.getBoundingClientRect(), scale = computeScale();
    const zoom = Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.003);
    const [left, top, boxWidth, boxHeight] = viewBox;
    // The point under the mouse stays where it is.
    const mouseX = left + boxWidth / 2 + (event.clientX - area.left - area.width / 2) * scale;
    const mouseY = top + boxHeight / 2 + (event.clientY - area.top - area.height / 2) * scale;
    setViewBox([mouseX - (mouseX - left) * zoom, mouseY - (mouseY - top) * zoom,
      boxWidth * zoom, boxHeight * zoom]);
  }, {passive: false});

  let lastEvent = null, movedPixels = 0;
  svg.addEventListener("pointerdown", (event) => { lastEvent = event; movedPixels = 0; });
  window.addEventListener("pointermove", (event) => {
    if (!lastEvent) return;
    const scale = computeScale();
    const dx = event.clientX - lastEvent.clientX, dy = event.clientY - lastEvent.clientY;
    movedPixels += Math.abs(dx) + Math.abs(dy);
    setViewBox([viewBox[0] - dx * scale, viewBox[1] - dy * scale, viewBox[2], viewBox[3]]);
    lastEvent = event;
  });
  window.addEventListener("pointerup", () => { lastEvent = null; });
  svg.addEventListener("click", (event) => {
    if (movedPixels >= 4) return;  // it was a drag
    const element = event.target.closest("[data-joint], [data-body]");
    if (element) selectElement(element);
    else select(undefined);
  });

  // All of the diagram is printed.
  let boxBeforePrint = wholeBox;
  window.addEventListener("beforeprint", () => { boxBeforePrint = viewBox; setViewBox(wholeBox); });
  window.addEventListener("afterprint", () => setViewBox(boxBeforePrint));
}

function saveDiagram(svg, wholeBox) {
  const copy = svg.cloneNode(true);
  copy.setAttribute("viewBox", wholeBox.join(" "));
  copy.setAttribute("width", wholeBox[2]);
  copy.setAttribute("height", wholeBox[3]);
  const text = new XMLSerializer().serializeToString(copy);
  download(URL.createObjectURL(new Blob([text], {type: "image/svg+xml"})), `${data.name}.svg`);
}

export function makeTables() {
  for (const filter of document.querySelectorAll("input.filter")) {
    const rows = filter.closest("section").querySelectorAll("tbody tr");
    filter.oninput = () => filterRows(rows, filter.value);
  }
  const rows = "tr[data-body], tr[data-joint], tr[data-link], tr[data-urdf-joint]";
  document.querySelectorAll(rows).forEach(makeSelectable);
}
