"use strict";
// The robot moves in the page: the forces of userfctR/NAME_robot.py, accelred, and steps in real
// time.  Arrays count from 1, as in Python; units are m, kg, s, rad.

// A X = B, by Gauss; B becomes X
function solve(A, B) {
  const n = A.length, width = n ? B[0].length : 0;
  for (let k = 0; k < n; k++) {
    let p = k;
    for (let i = k + 1; i < n; i++) if (Math.abs(A[i][k]) > Math.abs(A[p][k])) p = i;
    [A[k], A[p], B[k], B[p]] = [A[p], A[k], B[p], B[k]];
    for (let i = k + 1; i < n; i++) {
      const f = A[i][k] / A[k][k];
      if (f === 0) continue;
      for (let j = k; j < n; j++) A[i][j] -= f * A[k][j];
      for (let j = 0; j < width; j++) B[i][j] -= f * B[k][j];
    }
  }
  for (let k = n - 1; k >= 0; k--) {
    for (let j = 0; j < width; j++) {
      for (let i = k + 1; i < n; i++) B[k][j] -= A[k][i] * B[i][j];
      B[k][j] /= A[k][k];
    }
  }
  return B;
}

// The state s of a model, and its accelerations.
function makeModel({arrays, model, tables, forces, up, independent}) {
  const row = (values) => Float64Array.from(values), {tanh, sqrt, min, max, abs} = Math;
  const joints = arrays.q.length, zeros = () => new Float64Array(joints);
  const square = (rows) => Array.from({length: rows}, zeros);
  // pull: what a visitor adds, [number of a body, force, point], both in the axes of the body
  const s = {tsim: 0, hold: true, ground: true, friction: true, pull: null, qdd: zeros(), Qq: zeros(),
    uxd: row(arrays.ux), frc: square(4), trq: square(4), SWr: forces.map(({at}) => row([0, 0, 0, 0, 0, 0, 0, ...at]))};
  for (const [name, values] of Object.entries(arrays)) {
    s[name] = Array.isArray(values[0]) ? values.map(row) : row(values);
  }

  // --- the project's forces: a row for each joint, with its numbers in the user models
  const rows = (name, ...groups) => (tables[name] || []).map(
    ([joint, about]) => [joint, ...groups.map((group) => (model[group] || {})[about])]);
  const damping = rows("damping", "damping"), friction = rows("friction", "friction", "friction_speed");
  const sprung = rows("sprung", "spring_stiffness", "spring_reference");
  const low = rows("low", "q_min", "stop_stiffness"), high = rows("high", "q_max", "stop_stiffness");
  const held = rows("held", "hold_stiffness", "hold_damping", "effort");
  const bristles = (tables.bristles || []).map(([joint, about, state]) =>
    [joint, state, model.friction_stiffness[about], model.friction[about]]);
  const on = model.joint_forces || {}, ground = model.contact;
  const contacts = new Map((tables.contacts || []).map((contact) => [contact, 0].flat()));
  const rolling = new Map(tables.rolling), wrenches = new Map(tables.wrenches), springs = new Map(tables.springs);
  const stop = (depth, rate, stiffness) =>
    depth <= 0 ? 0 : max(0, stiffness * depth * (1 + rate / on.stop_speed));

  // how far a bristle is bent, one number or two; what is more than most slips back within time
  function bristle(state, rates, most, time) {
    const bent = rates.map((_, k) => s.ux[state + k]), kept = shorten(bent, most);
    rates.forEach((rate, k) => { s.uxd[state + k] = rate - (bent[k] - kept[k]) / time; });
    return shorten(bent.map((there, k) => there + time * rates[k]), most);
  }
  function shorten(vector, most) {
    const size = sqrt(vector.reduce((sum, x) => sum + x * x, 0));
    return size <= most ? vector : vector.map((x) => x * most / size);
  }

  function jointForces({q, qd, Qq}) {
    Qq.fill(0);
    if (on.damping && s.friction) for (const [j, d] of damping) Qq[j] -= d * qd[j];
    if (on.springs) for (const [j, k, rest] of sprung) Qq[j] -= k * (q[j] - rest);
    if (on.friction && s.friction) {
      for (const [j, f, v] of friction) Qq[j] -= f * tanh(qd[j] / v);
      for (const [j, state, k, f] of bristles) Qq[j] -= k * bristle(state, [qd[j]], f / k, on.friction_time)[0];
    }
    if (on.stops) {
      for (const [j, end, k] of low) Qq[j] += stop(end - q[j], -qd[j], k);
      for (const [j, end, k] of high) Qq[j] -= stop(q[j] - end, qd[j], k);
    }
    if (!s.hold || !model.hold || !model.hold.on) return;
    for (const [j, k, d, most] of held) {
      const push = k * (arrays.q[j] - q[j]) - d * qd[j];
      Qq[j] += most > 0 ? max(-most, min(most, push)) : push;
    }
  }
  s.user_ExtForces = (P, R, V, OM, A, OMP, _, tsim, number) => {
    const out = s.SWr[number], wrench = model[wrenches.get(number)];
    out.fill(0, 1, 7);
    if (contacts.has(number) && s.ground) contactForce(P, R, V, OM, out, number);
    if (wrench && wrench.start <= tsim && tsim < wrench.stop) {
      ["Fx", "Fy", "Fz", "Mx", "My", "Mz"].forEach((part, k) => { out[k + 1] = wrench[part]; });
    }
    return out;
  };
  // two directions in the ground, at right angles
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const sizes = up.map(abs), least = sizes.indexOf(min(...sizes));
  const second = cross(up, up.map((_, k) => +(k === least))), length = Math.hypot(...second);
  const across = [second.map((x) => x / length)];
  across.unshift(cross(across[0], up));
  const along = (way, v) => way[0] * v[1] + way[1] * v[2] + way[2] * v[3];

  // from the centre of a ball, or of a wheel with an axis in the body, to its lowest point
  function lowest(R, [radius, axis]) {
    const own = [1, 2, 3].map((i) => axis[0] * R[1][i] + axis[1] * R[2][i] + axis[2] * R[3][i]);
    const along = own.reduce((sum, x, i) => sum + x * up[i], 0), way = own.map((x, i) => up[i] - along * x);
    return way.map((x) => -radius * x / (Math.hypot(...way) || 1));
  }
  function contactForce(P, R, V, OM, out, number) {
    if (!rolling.has(number)) return groundForce(P, V, out, contacts.get(number));
    const arm = lowest(R, rolling.get(number)), spin = cross(row(OM).subarray(1), arm);
    groundForce([0, ...arm.map((x, i) => P[i + 1] + x)], [0, ...spin.map((x, i) => V[i + 1] + x)],
      out, contacts.get(number));
    cross(arm, out.subarray(1)).forEach((x, i) => { out[i + 4] = x; });
  }
  function groundForce(P, V, out, state) {
    const depth = ground.ground - along(up, P);
    const normal = ground.stiffness * depth * (1 - along(up, V) / ground.speed);
    const touches = depth > 0 && normal > 0, slip = across.map((way) => along(way, V));
    let pull = [0, 0];
    if (ground.bristle) {
      const most = touches ? ground.friction * ground.bristle : 0;
      pull = bristle(state, touches ? slip : pull, most, ground.bristle_time).map((x) => x / ground.bristle);
    } else if (touches && (slip[0] || slip[1])) {
      const speed = sqrt(slip[0] * slip[0] + slip[1] * slip[1]);
      pull = slip.map((v) => ground.friction * tanh(speed / ground.slip_speed) / speed * v);
    }
    for (const k of touches ? [0, 1, 2] : []) {
      out[k + 1] = normal * (up[k] - pull[0] * across[0][k] - pull[1] * across[1][k]);
    }
  }
  s.user_LinkForces = (Z, Zd, _, tsim, number) => {
    const name = springs.get(number);
    return name === undefined ? 0
      : model.link_stiffness[name] * (Z - model.link_length[name]) + model.link_damping[name] * Zd;
  };
  function setForces() {
    for (const vector of [...s.frc, ...s.trq, s.uxd]) vector.fill(0);
    if (equations.link) equations.link(s.frc, s.trq, zeros(), zeros(), zeros(), s, s.tsim);
    if (equations.extforces) equations.extforces(s.frc, s.trq, s, s.tsim);
    jointForces(s);
    if (!s.pull) return;
    const [body, f, at] = s.pull, arm = at.map((x, k) => x - s.l[k + 1][body]);
    for (const [k, i, j] of [[0, 1, 2], [1, 2, 0], [2, 0, 1]]) {
      s.frc[k + 1][body] += f[k];
      s.trq[k + 1][body] += arm[i] * f[j] - arm[j] * f[i];
    }
  }

  // --- accelred
  const {dependent = [], driven = [], cuts = 0, user = 0} = equations;
  const {couplings = [], driven: driving = []} = tables, leaders = [...independent, ...driven];
  const moving = [...independent, ...dependent, ...driving.map(([follower]) => follower)];
  const h = new Float64Array(cuts + user + 1), Jac = Array.from(h, zeros), M = square(joints), c = zeros();
  const pick = (columns) => Jac.slice(1).map((line) => columns.map((k) => line[k]));
  const solveFor = () => solve(pick(dependent), Array.from(h.subarray(1), (value) => [value]));
  // each joint's rate: [leader, factor] of some leaders; it changes only where there are cuts
  let share = null;
  const follow = (rates, k, rest) => share[k].reduce((sum, [i, x]) => sum + x * rates[leaders[i]], rest);

  // set q and qd of the dependent joints; gives what their qdd is beside their share, or null
  function closeLoops({q, qd}) {
    for (let turn = 0; ; turn++) {
      for (const line of Jac) line.fill(0);
      if (cuts) equations.cons_hJ(h, Jac, s);
      couplings.forEach(([follower, leader, m, b], k) => {
        h[cuts + k + 1] = q[follower] - m * q[leader] - b;
        Jac[cuts + k + 1][follower] = 1;
        Jac[cuts + k + 1][leader] = -m;
      });
      // m of h for each rad of a joint: how large the model is
      if (Jac.every((line, i) => abs(h[i]) <= 1e-9 * max(...line.map(abs)))) break;
      if (turn === 100) return null;
      solveFor().forEach(([x], i) => { q[dependent[i]] -= x; });
    }
    if (cuts || !share) {
      share = M.map(() => []);
      leaders.forEach((k, i) => share[k].push([i, 1]));
      solve(pick(dependent), pick(leaders)).forEach((line, d) => line.forEach((x, i) => {
        if (x !== 0) share[dependent[d]].push([i, -x]);
      }));
    }
    for (const k of dependent) qd[k] = follow(qd, k, 0);
    h.fill(0);
    if (cuts) equations.cons_jdqd(h, s);
    return solveFor();
  }

  // false where the loops cannot be closed
  s.accelerate = () => {
    const {q, qd, qdd} = s;
    for (const [follower, leader, m, b] of driving) {
      q[follower] = m * q[leader] + b;
      qd[follower] = m * qd[leader];
      qdd[follower] = m * qdd[leader];
    }
    const rest = equations.accelred ? [] : closeLoops(s);
    if (!rest) return false;
    setForces();
    if (equations.accelred) {
      equations.accelred(s, s.tsim);
      return true;
    }
    for (const line of M) line.fill(0);
    equations.dirdyna(M, c, s, s.tsim);
    for (const k of independent) qdd[k] = 0;
    dependent.forEach((k, d) => { qdd[k] = follow(qdd, k, -rest[d][0]); });
    const force = zeros();
    for (const k of moving) {
      force[k] = s.Qq[k] - c[k];
      for (const j of moving) force[k] -= M[k][j] * qdd[j];
    }
    // let the leaders feel the dependent joints
    for (const k of dependent) {
      for (const [i, x] of share[k]) {
        const to = leaders[i];
        force[to] += x * force[k];
        for (const j of moving) M[to][j] += x * M[k][j];
        for (const j of moving) M[j][to] += x * M[j][k];
      }
    }
    const mass = independent.map((k) => independent.map((j) => M[k][j]));
    solve(mass, independent.map((k) => [force[k]])).forEach(([x], i) => { qdd[independent[i]] = x; });
    dependent.forEach((k, d) => { qdd[k] = follow(qdd, k, -rest[d][0]); });
    return true;
  };

  // semi-implicit Euler
  s.advance = (step) => {
    const found = s.accelerate();
    for (const k of independent) {
      s.qd[k] += step * s.qdd[k];
      s.q[k] += step * s.qd[k];
    }
    for (let k = 1; k < s.ux.length; k++) s.ux[k] += step * s.uxd[k];
    s.tsim += step;
    return found;
  };
  return s;
}

// The buttons, and the mouse that pulls.  The argument is what page.js gives.
function makeLive({THREE, data, byId, q, names, settle, poses, makeArrows, rayOf, hit, camera, canvas, player}) {
  const {step, up, arrays, forces} = data.live, s = makeModel(data.live), pulled = forces.length;
  const mass = s.m.reduce((sum, m) => sum + m), weight = mass * (Math.hypot(...s.g) || 9.81);
  const arrow = makeArrows([...forces.map(() => false), true]);
  let running = false, before = 0, rate = 1, held = null;

  const write = () => names.forEach((name, k) => q.set(name, s.q[k + 1]));
  function show(about = `${s.tsim.toFixed(2)} s, ${rate.toFixed(2)} of real time`) {
    write();
    settle();
    const {bodies} = poses(), {body, at, force} = held || {at: [0, 0, 0], force: [0, 0, 0]};
    forces.forEach((one, k) => k && arrow(k, bodies.get(one.body), one.at, s.SWr[k].subarray(1, 4), weight));
    arrow(pulled, bodies.get(body), at, force, weight);
    byId("live-clock").textContent = about;
  }

  // a spring and a damper between the point that is held and the mouse
  function pull(time) {
    write();
    const pose = poses().bodies.get(held.body), at = new THREE.Vector3(...held.at).applyMatrix4(pose);
    const force = held.target.clone().sub(at).multiplyScalar(100 * mass).clampLength(0, 3 * weight);
    if (held.last) force.addScaledVector(at.clone().sub(held.last), -40 * s.m[held.number] / time);
    Object.assign(held, {last: at, force: force.toArray()});
    const turn = new THREE.Quaternion().setFromRotationMatrix(pose).invert();
    s.pull = [held.number, force.applyQuaternion(turn).toArray(), held.at];
  }

  const every = Math.ceil(1e-3 / step);
  function tick(now) {
    if (!running) return;
    const begin = performance.now(), first = s.tsim, passed = (now - before) / 1000;
    before = now;
    let found = true;
    while (found && s.tsim < first + Math.min(passed, 0.5) && performance.now() - begin < 12 + 500 * passed) {
      if (held) pull(every * step);
      for (let k = 0; k < every && found; k++) found = s.advance(step);
    }
    if (passed > 0) rate += 0.1 * ((s.tsim - first) / passed - rate);
    if (found && s.q.every(Number.isFinite)) show();
    else start(0, "No step was short enough for that: it starts again.");
    requestAnimationFrame(tick);
  }
  function play(on) {
    running = on;
    byId("live-run").textContent = on ? "Stop" : "Let it move";
    if (!on) return;
    player.play(false);
    if (names.some((name, k) => q.get(name) !== s.q[k + 1])) {  // a slider was moved
      names.forEach((name, k) => { s.q[k + 1] = q.get(name); });
      s.qd.fill(0);
    }
    before = performance.now();
    requestAnimationFrame(tick);
  }

  // the shifts of a floating base, before it turns
  const root = data.mbs.bodies[0].joints, turns = root.findIndex(({type}) => type[0] === "R");
  const lifts = root.slice(0, turns).filter(({nature}) => nature === "independent");
  function start(height = 0, about = undefined) {
    for (const name of ["q", "qd", "ux"]) s[name].set(arrays[name]);
    s.qdd.fill(0);
    s.tsim = 0;
    for (const {name, type} of lifts) s.q[names.indexOf(name) + 1] += height * up[type[1] - 1];
    show(about);
  }
  byId("live-run").onclick = () => play(!running);
  byId("live-start").onclick = () => start();
  byId("live-drop").hidden = lifts.length !== 3;
  byId("live-drop").onclick = () => { start(data.size / 2); play(true); };
  const gravity = byId("live-gravity"), {tables, model: {joint_forces: on = {}, hold}} = data.live;
  gravity.oninput = () => {
    arrays.g.forEach((g, k) => { s.g[k] = g * gravity.value; });
    byId("live-g").textContent = `${Math.hypot(...s.g).toFixed(2)} m/s²`;
  };
  const stands = tables.contacts && tables.contacts.length > 0;
  if (lifts.length === 3 && !stands) gravity.value = 0;  // it would be out of sight in a second
  gravity.oninput();
  for (const [name, there] of [["hold", hold], ["ground", stands], ["friction", on.friction || on.damping]]) {
    byId(`live-${name}`).onchange = (event) => { s[name] = event.target.checked; };
    byId(`live-${name}`).parentNode.hidden = !there;
  }

  const plane = new THREE.Plane();
  canvas.addEventListener("pointermove", (event) => held && rayOf(event).ray.intersectPlane(plane, held.target));
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { held = s.pull = null; });
  // true if the mouse has caught a body of the moving robot
  const grab = (event) => {
    const {body, point} = running && hit(event) || {};
    if (!body) return false;
    const joint = data.mbs.bodies.find(({name}) => name === body).joints.at(-1).name;
    const at = point.clone().applyMatrix4(poses().bodies.get(body).clone().invert());
    held = {body, number: names.indexOf(joint) + 1, at: at.toArray(), target: point.clone(), force: [0, 0, 0]};
    plane.setFromNormalAndCoplanarPoint(camera.getWorldDirection(new THREE.Vector3()), point);
    canvas.setPointerCapture(event.pointerId);
    return true;
  };
  return {s, play, start, show, grab};
}
