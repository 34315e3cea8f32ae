// The diagram, moved by dragging and zoomed by the wheel, and the filters of tables.

import {byId, data, save} from "./basics.js";
import {choose, chooseWhat, makeChoosable} from "./choose.js";
import {filterRows} from "./panel.js";

export function makeDiagram() {
  const svg = byId("paper").querySelector("svg");
  if (!svg) return;
  const full = svg.viewBox.baseVal;
  const whole = [full.x, full.y, full.width, full.height];
  let box = whole;
  const set = (next) => {
    box = next;
    svg.setAttribute("viewBox", box.join(" "));
  };
  const scale = () => Math.max(box[2] / svg.clientWidth, box[3] / svg.clientHeight);
  svg.removeAttribute("width");
  svg.removeAttribute("height");
  byId("diagram-fit").onclick = () => set(whole);
  byId("diagram-full").onclick = () => set([whole[0], whole[1], svg.clientWidth, svg.clientHeight]);
  byId("diagram-save").onclick = () => {
    const copy = svg.cloneNode(true);
    copy.setAttribute("viewBox", whole.join(" "));
    copy.setAttribute("width", whole[2]);
    copy.setAttribute("height", whole[3]);
    save(URL.createObjectURL(new Blob([new XMLSerializer().serializeToString(copy)],
      {type: "image/svg+xml"})), `${data.name}.svg`);
  };
  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    const area = svg.getBoundingClientRect(), k = scale();
    const by = Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.003);
    const x = box[0] + box[2] / 2 + (event.clientX - area.left - area.width / 2) * k;
    const y = box[1] + box[3] / 2 + (event.clientY - area.top - area.height / 2) * k;
    set([x - (x - box[0]) * by, y - (y - box[1]) * by, box[2] * by, box[3] * by]);
  }, {passive: false});
  let held = null, moved = 0;
  svg.addEventListener("pointerdown", (event) => { held = event; moved = 0; });
  window.addEventListener("pointermove", (event) => {
    if (!held) return;
    const k = scale(), dx = event.clientX - held.clientX, dy = event.clientY - held.clientY;
    moved += Math.abs(dx) + Math.abs(dy);
    set([box[0] - dx * k, box[1] - dy * k, box[2], box[3]]);
    held = event;
  });
  window.addEventListener("pointerup", () => { held = null; });
  svg.addEventListener("click", (event) => {
    if (moved >= 4) return;
    const what = event.target.closest("[data-joint], [data-body]");
    if (what) chooseWhat(what);
    else choose(undefined);
  });
  // on paper there is all of it
  let before = whole;
  window.addEventListener("beforeprint", () => { before = box; set(whole); });
  window.addEventListener("afterprint", () => set(before));
}

export function makeTables() {
  for (const filter of document.querySelectorAll("input.filter")) {
    const rows = filter.closest("section").querySelectorAll("tbody tr");
    filter.oninput = () => filterRows(rows, filter.value);
  }
  const rows = "tr[data-body], tr[data-joint], tr[data-link], tr[data-urdf-joint]";
  document.querySelectorAll(rows).forEach(makeChoosable);
}
