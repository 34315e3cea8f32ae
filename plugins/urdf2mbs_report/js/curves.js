// Curves over time: of what changes most, or of one joint or force.
//
// Each kind (angles, lengths, forces, energies) has one scale, at least MIN_SPANS wide, so that a
// robot that stands still looks still.

import {byId, createElement, data, robotSize} from "./basics.js";
import {getUnit, onUnitChange} from "./units.js";

const MAX_CURVES = 8;
const HEIGHT = 150, LEFT = 56, RIGHT = 12, TOP = 8, BOTTOM = 20;  // of the plot and its margins (px)
const GRAVITY = 9.81;  // m/s^2
const weight = GRAVITY * data.mbs.bodies.reduce((sum, body) => sum + (body.mass || 0), 0);
// The smallest scale of each kind, in its own unit.
const MIN_SPANS = {R: Math.PI / 36, T: 0.02 * robotSize, force: 0.02 * weight || 1, energy: 1e-3};

// What can be chosen: {name, kind, curves: [{name, values}]}.
let plots = [], plotTimes = null;

// The factor and the symbol of a kind.
function getPlotUnit(kind) {
  if (kind === "force") return {factor: 1, symbol: " N"};
  if (kind === "energy") return {factor: 1, symbol: " J"};
  return getUnit(kind);
}

const findRange = (values) => values.reduce(
  ([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
const measureChange = ({values}) => {
  const [low, high] = findRange(values);
  return high - low;
};

// Offer the curves of a motion: {name, kind, values} of each joint, force and energy.
export function makePlots(times, curves, onChange) {
  plotTimes = times;
  const largest = (kind) => curves
    .filter((curve) => curve.kind === kind && (kind === "energy" || measureChange(curve) > 1e-9))
    .sort((a, b) => measureChange(b) - measureChange(a)).slice(0, MAX_CURVES);
  plots = [["Angles", "R"], ["Lengths", "T"], ["Forces", "force"], ["Energy", "energy"]]
    .map(([name, kind]) => ({name, kind, curves: largest(kind)}))
    .filter((plot) => plot.curves.length);
  plots.push(...curves.filter(({kind}) => kind !== "energy")
    .map((curve) => ({name: curve.name, kind: curve.kind, curves: [curve]})));
  plots.forEach(({name}, index) => byId("curve").add(new Option(name, index)));
  byId("curve").onchange = onChange;
  onUnitChange(onChange);
  new ResizeObserver(onChange).observe(byId("curves"));
}

// A round step of an axis: 1, 2 or 5 times a power of ten.
function chooseStep(span, maxCount) {
  const power = 10 ** Math.floor(Math.log10(span / maxCount));
  return [1, 2, 5, 10].map((digit) => digit * power).find((step) => span / step <= maxCount);
}

function listTicks(low, high, maxCount) {
  const step = chooseStep(high - low || 1, maxCount), ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k <= high / step + 1e-9; k++) ticks.push(k * step);
  return {ticks, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

// The range of the values of a plot: at least as wide as the smallest scale of its kind.
function findScale({kind, curves}, factor) {
  const ranges = curves.map(({values}) => findRange(values));
  const low = Math.min(...ranges.map(([first]) => first));
  const high = Math.max(...ranges.map(([, last]) => last));
  const half = 1.06 * Math.max(high - low, MIN_SPANS[kind]) / 2;
  return [((low + high) / 2 - half) * factor, ((low + high) / 2 + half) * factor];
}

const chooseColor = (number) => `hsl(${number * 137.5 % 360} 60% 48%)`;

// Draw the plot that is chosen, with a line at a time, and the values of a frame below it.
export function drawPlot(time, frame) {
  const plot = plots[byId("curve").value];
  if (!plot) return;
  const {factor, symbol} = getPlotUnit(plot.kind), [low, high] = findScale(plot, factor);
  const canvas = byId("curves"), pixelRatio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth || 600;
  canvas.width = Math.round(width * pixelRatio);
  canvas.height = Math.round(HEIGHT * pixelRatio);
  const pen = canvas.getContext("2d");
  if (pen) {
    pen.scale(pixelRatio, pixelRatio);
    drawAxes(pen, {width, low, high, symbol});
    drawCurves(pen, {plot, width, low, high, factor});
    const x = computeX(time, width);
    strokeLine(pen, [x, TOP], [x, HEIGHT - BOTTOM], getColor("--ink"));
  }
  const {digits} = listTicks(low, high, 4);
  byId("legend").replaceChildren(...plot.curves.map(({name, values}, number) => {
    const item = createElement("li", "", `${name} `), mark = createElement("i");
    mark.style.background = chooseColor(number);
    item.prepend(mark);
    const value = +(values[frame] * factor).toFixed(digits + 1) + 0;
    item.append(createElement("b", "", `${value}${symbol}`));
    if (plot.kind === "force") {
      item.append(`, at most ${+findRange(values)[1].toPrecision(4)}${symbol}`);
    }
    return item;
  }));
}

const getColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
const computeX = (time, width) => {
  const first = plotTimes[0], last = plotTimes[plotTimes.length - 1];
  return LEFT + (time - first) / (last - first || 1) * (width - LEFT - RIGHT);
};
const computeY = (value, low, high) =>
  HEIGHT - BOTTOM - (value - low) / (high - low) * (HEIGHT - TOP - BOTTOM);

// The time (s) at a place of the canvas (px).
export function findPlotTime(x) {
  const canvas = byId("curves"), first = plotTimes[0], last = plotTimes[plotTimes.length - 1];
  return first + (x - LEFT) / (canvas.clientWidth - LEFT - RIGHT) * (last - first);
}

function strokeLine(pen, from, to, color) {
  pen.strokeStyle = color;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(...from);
  pen.lineTo(...to);
  pen.stroke();
}

function drawAxes(pen, {width, low, high, symbol}) {
  pen.font = "11px system-ui, 'DejaVu Sans', sans-serif";
  pen.fillStyle = getColor("--soft");
  pen.textBaseline = "middle";
  pen.textAlign = "right";
  const values = listTicks(low, high, 4);
  for (const value of values.ticks) {
    const y = Math.round(computeY(value, low, high)) + 0.5, isZero = Math.abs(value) < 1e-9 * high;
    strokeLine(pen, [LEFT, y], [width - RIGHT, y], getColor(isZero ? "--soft" : "--line"));
    pen.fillText(`${+value.toFixed(values.digits) + 0}${symbol}`, LEFT - 6, y);
  }
  pen.textAlign = "center";
  const first = plotTimes[0], last = plotTimes[plotTimes.length - 1];
  const times = listTicks(first, last, Math.max(2, Math.floor(width / 110)));
  for (const time of times.ticks) {
    const x = computeX(time, width);
    strokeLine(pen, [x, HEIGHT - BOTTOM], [x, HEIGHT - BOTTOM + 4], getColor("--soft"));
    pen.fillText(`${+time.toFixed(times.digits) + 0} s`, Math.min(x, width - 16), HEIGHT - BOTTOM + 12);
  }
}

function drawCurves(pen, {plot, width, low, high, factor}) {
  pen.lineWidth = 1.5;
  pen.lineJoin = "round";
  plot.curves.forEach(({values}, number) => {
    pen.strokeStyle = chooseColor(number);
    pen.beginPath();
    values.forEach((value, frame) =>
      pen.lineTo(computeX(plotTimes[frame], width), computeY(value * factor, low, high)));
    pen.stroke();
  });
}
