// Closed loops: cuts keep two points together (ball), at a distance (rod), or two bodies together
// (solid).  In the axes of the base, with p1 and p2 the points, and a_i, b_i the axes of the bodies:
//
//   ball   h = p1 - p2
//   rod    h = |p1 - p2| - length
//   solid  h = p1 - p2 and, times the size of the robot, (a_1 x b_1 + a_2 x b_2 + a_3 x b_3) / 2
//
// h = 0 is solved by steps of Gauss and Newton: dq = -J^T (J J^T + damping)^-1 h, with J = dh/dq,
// is the shortest step that closes the loops to first order.

import {bodyByName, data, robotSize, vector} from "./basics.js";
import {computeMbsPoses} from "./kinematics.js";

// A loop with a smaller gap (m) is closed.
export const MAX_GAP = Math.min(1e-3, 1e-3 * robotSize);
const TOLERANCE = 1e-7 * robotSize;  // m
const MAX_STEPS = 20;
const MAX_CHANGE = 0.3;  // of a joint in one step (rad, m)
const DAMPING = 1e-9;  // relative to the mean of the diagonal of J J^T

// All joints that move a body, from the base on.
function listJoints(bodyName) {
  const joints = [];
  for (let body = bodyByName.get(bodyName); body; body = bodyByName.get(body.parent)) {
    joints.unshift(...body.joints);
  }
  return joints;
}

// The cuts: those of the page, with the joints that move one of their ends, and not the other.
export const cuts = data.cuts.map((cut) => {
  const [joints1, joints2] = [cut.first, cut.second].map(([body]) => listJoints(body));
  return {...cut, joints1: joints1.filter((joint) => !joints2.includes(joint)),
    joints2: joints2.filter((joint) => !joints1.includes(joint))};
});
// The joints that can close a loop, by name.
export const loopJoints = new Map(cuts.flatMap(({joints1, joints2}) => [...joints1, ...joints2])
  .map((joint) => [joint.name, joint]));

const locate = ([body, xyz], {bodies}) => vector(...xyz).applyMatrix4(bodies.get(body));

// The distance (m) by which a cut is open.
export function measureGap(cut, poses) {
  const distance = locate(cut.first, poses).distanceTo(locate(cut.second, poses));
  return cut.kind === "rod" ? Math.abs(distance - cut.length) : distance;
}

// The sum of cross products that turns the axes of one body to those of another.
function measureTurn([body1], [body2], {bodies}) {
  const turn = vector();
  for (let axis = 0; axis < 3; axis++) {
    const [a, b] = [body1, body2].map((body) => vector().setFromMatrixColumn(bodies.get(body), axis));
    turn.add(a.cross(b));
  }
  return turn.multiplyScalar(0.5);
}

// The velocity of a point, and the angular velocity, for a unit rate of a joint.
function computeTwist({name, type}, point, {joints}) {
  const pose = joints.get(name), axis = vector().setFromMatrixColumn(pose, +type[1] - 1);
  if (type[0] === "T") return {linear: axis, angular: vector()};
  const arm = point.clone().sub(vector().setFromMatrixPosition(pose));
  return {linear: axis.clone().cross(arm), angular: axis};
}

// The equations of a cut: {value, slopes}, where slopes has dh/dq by the names of the joints.
function listEquations(cut, poses) {
  const ends = [locate(cut.first, poses), locate(cut.second, poses)];
  const difference = ends[0].clone().sub(ends[1]), distance = difference.length();
  const twists = [[cut.joints1, ends[0], 1], [cut.joints2, ends[1], -1]].flatMap(
    ([joints, point, sign]) => joints.map((joint) =>
      ({name: joint.name, sign, ...computeTwist(joint, point, poses)})));
  const makeEquation = (value, computeSlope) => ({value, slopes: new Map(
    twists.map((twist) => [twist.name, twist.sign * computeSlope(twist)]))});
  if (cut.kind === "rod") {
    const direction = difference.clone().divideScalar(distance || 1);
    return [makeEquation(distance - cut.length, ({linear}) => linear.dot(direction))];
  }
  const equations = ["x", "y", "z"].map((axis) =>
    makeEquation(difference[axis], ({linear}) => linear[axis]));
  if (cut.kind === "solid") {
    const turn = measureTurn(cut.first, cut.second, poses);
    equations.push(...["x", "y", "z"].map((axis) =>
      makeEquation(robotSize * turn[axis], ({angular}) => -robotSize * angular[axis])));
  }
  return equations;
}

// Solve A x = b for a symmetric positive definite matrix, by the method of Cholesky: A = L L^T.
function solveSymmetric(A, b) {
  const n = b.length, L = A.map(() => new Float64Array(n)), x = [...b];
  const sumProducts = (first, second, count) => {
    let sum = 0;
    for (let k = 0; k < count; k++) sum += first[k] * second[k];
    return sum;
  };
  for (let row = 0; row < n; row++) {
    for (let column = 0; column < row; column++) {
      L[row][column] = (A[row][column] - sumProducts(L[row], L[column], column)) / L[column][column];
    }
    L[row][row] = Math.sqrt(Math.max(A[row][row] - sumProducts(L[row], L[row], row), 1e-300));
    x[row] = (x[row] - sumProducts(L[row], x, row)) / L[row][row];
  }
  for (let row = n - 1; row >= 0; row--) {
    x[row] /= L[row][row];
    for (let column = 0; column < row; column++) x[column] -= L[row][column] * x[row];
  }
  return x;
}

// The step of Gauss and Newton, by the names of the joints.
function computeStep(equations, names) {
  const rows = equations.map(({slopes}) => names.map((name) => slopes.get(name) || 0));
  const products = rows.map((row) => rows.map((next) =>
    row.reduce((sum, slope, k) => sum + slope * next[k], 0)));
  const trace = products.reduce((sum, row, k) => sum + row[k], 0);
  products.forEach((row, k) => { row[k] += DAMPING * trace / rows.length + 1e-300; });
  const multipliers = solveSymmetric(products, equations.map(({value}) => -value));
  return names.map((_, k) => rows.reduce((sum, row, r) => sum + row[k] * multipliers[r], 0));
}

// Close the loops by some joints, in their limits; the positions are changed.  applyFollowers moves
// the joints that follow others.  Returns true if all loops are closed.
export function closeLoops(positions, names, limits, applyFollowers) {
  const atLimits = new Set();
  for (let count = 0; count < MAX_STEPS; count++) {
    const poses = computeMbsPoses(positions);
    const equations = cuts.flatMap((cut) => listEquations(cut, poses));
    if (equations.every(({value}) => Math.abs(value) <= TOLERANCE)) return true;
    const free = names.filter((name) => !atLimits.has(name));
    const step = computeStep(equations, free);
    const largest = Math.max(...step.map(Math.abs), 0);
    if (!(largest > 1e-14)) break;
    const scale = Math.min(1, MAX_CHANGE / largest);
    free.forEach((name, k) => {
      const [low, high] = limits.get(name), target = positions.get(name) + scale * step[k];
      positions.set(name, Math.min(Math.max(target, low), high));
      if (target < low || target > high) atLimits.add(name);
    });
    applyFollowers();
  }
  const poses = computeMbsPoses(positions);
  return cuts.every((cut) => measureGap(cut, poses) <= MAX_GAP)
    && cuts.flatMap((cut) => listEquations(cut, poses))
      .every(({value}) => Math.abs(value) <= MAX_GAP);
}
