// The units in which positions are shown: degrees and mm, or rad and m, as the user chooses.

import {byId} from "./basics.js";

const isInRadians = () => byId("unit").value === "rad";

// The unit of a joint, by its type: {factor, symbol, digits}.
export function getUnit(type) {
  if (isInRadians()) return {factor: 1, symbol: type[0] === "R" ? " rad" : " m", digits: 4};
  if (type[0] === "R") return {factor: 180 / Math.PI, symbol: "°", digits: 1};
  return {factor: 1000, symbol: " mm", digits: 1};
}

// A position without its unit; rounding leaves no -0.
export function formatPosition(type, position) {
  const {factor, digits} = getUnit(type);
  return `${+(position * factor).toFixed(digits) + 0}`;
}

export const formatWithUnit = (type, position) =>
  `${formatPosition(type, position)}${getUnit(type).symbol}`;

const unitListeners = [];
// The listener is called after the user has chosen other units.
export const onUnitChange = (listener) => unitListeners.push(listener);
byId("unit").onchange = () => unitListeners.forEach((listener) => listener());
