// The tables: rows that select, by the mouse or by keys; one filter; long tables are folded.

import {byId, createElement} from "./basics.js";
import {filterRows} from "./panel.js";
import {makeRoving} from "./roving.js";
import {makeSelectable} from "./selection.js";

const FOLDED_ROWS = 12;  // as in page.css

export function makeTables() {
  const frames = [...document.querySelectorAll(".scroll")];
  const refreshAll = frames.map(makeTable);
  byId("filter-tables").oninput = (event) => {
    const text = event.target.value;
    for (const frame of frames) {
      const rows = [...frame.querySelectorAll("tbody tr")];
      filterRows(rows, text);
      frame.classList.toggle("filtered", text !== "");
      frame.hidden = rows.every((row) => row.hidden);
    }
    refreshAll.forEach((refresh) => refresh());
  };
}

// Let links within the page scroll: in a notebook's iframe, the browser would load the notebook.
export function makeLinks() {
  for (const link of document.querySelectorAll('a[href^="#"]')) {
    link.addEventListener("click", (event) => {
      event.preventDefault();
      byId(link.hash.slice(1)).scrollIntoView();
    });
  }
}

// Make the rows of a table, and the button that unfolds it, one stop of Tab.
function makeTable(frame) {
  const table = frame.querySelector("table"), rows = [...table.querySelectorAll("tbody tr")];
  const selectableRows = rows.filter(({dataset: {body, joint, link, urdfJoint}}) =>
    [body, joint, link, urdfJoint].some((name) => name !== undefined));
  selectableRows.forEach(makeSelectable);
  if (selectableRows.length) table.role = "grid";
  else if (frame.scrollWidth > frame.clientWidth) frame.tabIndex = 0;
  if (rows.length > FOLDED_ROWS + 3) foldTable(frame, rows.length);
  return makeRoving(frame, "tr.selectable, .more");
}

function foldTable(frame, rowCount) {
  const button = createElement("button", "more");
  const fold = (isFolded) => {
    frame.classList.toggle("folded", isFolded);
    button.textContent = isFolded ? `Show all ${rowCount} rows` : "Show fewer rows";
    button.ariaExpanded = !isFolded;
  };
  button.onclick = () => fold(!frame.classList.contains("folded"));
  fold(true);
  frame.append(button);
}
