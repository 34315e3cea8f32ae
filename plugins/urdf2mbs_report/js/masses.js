// The centres of mass, and the boxes that show inertias.

import {data, matrix, robotSize, vector} from "./basics.js";
import {solids} from "./geometry.js";
import {addOfKind, getGroup, setPose} from "./scene.js";

export function drawMasses() {
  const largestMass = Math.max(1e-9, ...data.mbs.bodies.map((body) => body.mass || 0));
  for (const body of data.mbs.bodies) {
    if (body.mass) addCentreOfMass(body, largestMass);
    if (body.mass && body.inertia) addInertiaBox(body);
  }
}

// The volume of the ball grows with the mass.
function addCentreOfMass(body, largestMass) {
  const radius = robotSize * 0.028 * Math.cbrt(body.mass / largestMass) + robotSize * 0.003;
  const ball = new THREE.Mesh(solids.sphere(radius), new THREE.MeshPhongMaterial(
    {color: 0x7a1fa2, transparent: true, opacity: 0.75, depthTest: false}));
  ball.position.set(...(body.com || [0, 0, 0]));
  ball.renderOrder = 4;
  addOfKind("coms", getGroup("mbs", body.name), ball);
}

// Add the uniform box that has the mass m and the inertia of a body.  Its edges s_x, s_y, s_z are
// along the principal axes: I_x = m/12 (s_y^2 + s_z^2), so s_x^2 = 12/m ((I_x+I_y+I_z)/2 - I_x).
function addInertiaBox(body) {
  const [xx, xy, xz, yy, yz, zz] = body.inertia;
  const {moments, axes} = computePrincipalAxes([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
  const halfSum = (moments[0] + moments[1] + moments[2]) / 2;
  const edges = moments.map((moment) => Math.sqrt(Math.max(12 * (halfSum - moment) / body.mass, 0)));
  const minEdge = 2e-3 * robotSize;
  const box = new THREE.Mesh(solids.box(edges.map((edge) => Math.max(edge, minEdge))),
    new THREE.MeshPhongMaterial({color: 0x18a058, transparent: true, opacity: 0.4, depthWrite: false}));
  setPose(box, matrix().makeBasis(...axes).setPosition(...(body.com || [0, 0, 0])));
  addOfKind("inertias", getGroup("mbs", body.name), box);
}

// The principal moments and axes of a symmetric matrix A, by Jacobi's rotations: V^T A V is made
// diagonal by rotations in the planes of two axes; the columns of V are the principal axes.
function computePrincipalAxes(A) {
  const V = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 30; sweep++) {
    for (const [i, j] of [[0, 1], [0, 2], [1, 2]]) {
      if (A[i][j] === 0) continue;
      const angle = Math.atan2(2 * A[i][j], A[j][j] - A[i][i]) / 2;
      const c = Math.cos(angle), s = Math.sin(angle);
      for (const row of [...A, ...V]) {
        [row[i], row[j]] = [c * row[i] - s * row[j], s * row[i] + c * row[j]];
      }
      for (let k = 0; k < 3; k++) {
        [A[i][k], A[j][k]] = [c * A[i][k] - s * A[j][k], s * A[i][k] + c * A[j][k]];
      }
      A[i][j] = A[j][i] = 0;
    }
  }
  const [x, y] = [0, 1].map((k) => vector(V[0][k], V[1][k], V[2][k]));
  return {moments: [A[0][0], A[1][1], A[2][2]], axes: [x, y, x.clone().cross(y)]};
}
