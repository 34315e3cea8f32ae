// three.js, which draws the 3D model: the page has it gzipped.

import {byId, createElement, decompress} from "./basics.js";

// Run three.js, which defines THREE.
async function loadViewer() {
  const text = new TextDecoder().decode(await decompress(byId("viewer").textContent.trim()));
  document.head.append(createElement("script", "", text));
}

await loadViewer();
