"use strict";
(() => {
  const data = JSON.parse(document.getElementById("viewer-data").textContent);
  const box = document.querySelector(".viewer");
  const canvas = box.querySelector("canvas"), play = box.querySelector(".play");
  const choice = box.querySelector("select"), slider = box.querySelector("input"), time = box.querySelector("output");
  const gl = canvas.getContext("webgl", { antialias: true, alpha: true });
  if (!gl) { box.textContent = "This browser shows no 3-D graphics (WebGL)."; return; }
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const shader = (kind, text) => { const s = gl.createShader(kind); gl.shaderSource(s, text); gl.compileShader(s); return s; };
  const program = gl.createProgram();
  gl.attachShader(program, shader(gl.VERTEX_SHADER,
    "attribute vec3 p,n;uniform mat4 m,v;varying vec3 w;void main(){w=mat3(m)*n;gl_Position=v*m*vec4(p,1.);}"));
  gl.attachShader(program, shader(gl.FRAGMENT_SHADER,
    "precision mediump float;varying vec3 w;uniform vec4 c;uniform float flat_;void main(){" +
    "float d=abs(dot(normalize(w+1e-6),normalize(vec3(.4,-.6,.8))));gl_FragColor=vec4(c.rgb*mix(.45+.6*d,1.,flat_),c.a);}"));
  gl.linkProgram(program); gl.useProgram(program);
  const at = (name) => gl.getUniformLocation(program, name);
  const spot = { m: at("m"), v: at("v"), c: at("c"), flat: at("flat_"), p: gl.getAttribLocation(program, "p"), n: gl.getAttribLocation(program, "n") };
  const buffer = (values) => { const b = gl.createBuffer(); gl.bindBuffer(gl.ARRAY_BUFFER, b); gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW); return b; };

  function solid(part) {
    const v = new Uint16Array(bytes(part.vertices)), f = new Uint16Array(bytes(part.triangles));
    const p = new Float32Array(f.length * 3), n = new Float32Array(f.length * 3);
    for (let i = 0; i < f.length; i++) for (let k = 0; k < 3; k++) p[3 * i + k] = part.offset[k] + part.scale * v[3 * f[i] + k];
    for (let i = 0; i < p.length; i += 9) {
      const a = [p[i + 3] - p[i], p[i + 4] - p[i + 1], p[i + 5] - p[i + 2]], b = [p[i + 6] - p[i], p[i + 7] - p[i + 1], p[i + 8] - p[i + 2]];
      const c = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
      const l = Math.hypot(...c) || 1;
      for (let k = 0; k < 9; k++) n[i + k] = c[k % 3] / l;
    }
    return { link: part.link, colour: part.colour, count: f.length, p: buffer(p), n: buffer(n) };
  }
  const robots = data.robots.map((robot) => robot.parts.map(solid));
  const motions = data.motions.map((motion) => {
    const path = new Float32Array(bytes(motion.path)), poses = new Float32Array(bytes(motion.poses));
    const marks = new Float32Array(bytes(motion.waypoints));
    let reach = 0.2;
    for (let i = 0; i < poses.length; i += 12) reach = Math.max(reach, Math.hypot(poses[i + 3], poses[i + 7], poses[i + 11]));
    for (let i = 0; i < path.length; i += 3) reach = Math.max(reach, Math.hypot(path[i], path[i + 1], path[i + 2]));
    const cross = [], s = 0.02 * reach;
    for (let i = 0; i < marks.length; i += 3) for (let k = 0; k < 3; k++) for (const side of [-s, s])
      cross.push(...[0, 1, 2].map((j) => marks[i + j] + (j === k ? side : 0)));
    const floor = [];
    for (let i = -5; i <= 5; i++) { const g = (reach * i) / 4, e = reach * 1.25; floor.push(g, -e, 0, g, e, 0, -e, g, 0, e, g, 0); }
    return { ...motion, reach, poses, pathCount: path.length / 3, path: buffer(path), cross: buffer(new Float32Array(cross)), crossCount: cross.length / 3,
      floor: buffer(new Float32Array(floor)), floorCount: floor.length / 3 };
  });
  motions.forEach((motion, i) => choice.add(new Option(motion.name, i)));

  let yaw = 0.8, pitch = 0.42, zoom = 1, now = 0, running = !matchMedia("(prefers-reduced-motion: reduce)").matches, last = 0;
  const rest = 0.7;
  const colour = (name) => {
    const raw = getComputedStyle(document.documentElement).getPropertyValue(name).trim().slice(1);
    const full = raw.length === 3 ? [...raw].map((c) => c + c).join("") : raw;
    return [0, 2, 4].map((i) => parseInt(full.slice(i, i + 2), 16) / 255);
  };
  const multiply = (a, b) => { const o = new Float32Array(16); for (let c = 0; c < 4; c++) for (let r = 0; r < 4; r++) for (let k = 0; k < 4; k++) o[4 * c + r] += a[4 * k + r] * b[4 * c + k]; return o; };
  function view(motion) {
    const d = motion.reach * 2.5 / zoom, cy = Math.cos(yaw), sy = Math.sin(yaw), cp = Math.cos(pitch), sp = Math.sin(pitch);
    const eye = [d * cp * cy, d * cp * sy, d * sp + motion.reach * 0.3];
    const z = [cp * cy, cp * sy, sp], x = [-sy, cy, 0], y = [-sp * cy, -sp * sy, cp];
    const dot = (a) => -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2]);
    const look = new Float32Array([x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, dot(x), dot(y), dot(z), 1]);
    const aspect = canvas.width / canvas.height, f = 2.2 * Math.min(1, aspect * 0.9), near = d * 0.02, far = d * 6;
    return multiply(new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]), look);
  }
  const identity = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
  function placed(motion, link) {
    const share = Math.min(now / motion.duration, 1) * (motion.frames - 1), low = Math.min(Math.floor(share), motion.frames - 2), part = share - low;
    const a = 12 * (low * motion.links + link), b = a + 12 * motion.links, o = new Float32Array(16);
    for (let r = 0; r < 3; r++) for (let c = 0; c < 4; c++) o[4 * c + r] = motion.poses[a + 4 * r + c] * (1 - part) + motion.poses[b + 4 * r + c] * part;
    o[15] = 1;
    return o;
  }
  function lines(points, count, rgb, kind) {
    gl.disableVertexAttribArray(spot.n); gl.vertexAttrib3f(spot.n, 0, 0, 1);
    gl.bindBuffer(gl.ARRAY_BUFFER, points); gl.vertexAttribPointer(spot.p, 3, gl.FLOAT, false, 0, 0);
    gl.uniformMatrix4fv(spot.m, false, identity); gl.uniform1f(spot.flat, 1); gl.uniform4f(spot.c, ...rgb, 1);
    gl.drawArrays(kind, 0, count);
  }
  function draw() {
    const motion = motions[choice.value || 0], ratio = Math.min(devicePixelRatio || 1, 2);
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    gl.viewport(0, 0, width, height); gl.clearColor(0, 0, 0, 0); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT); gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix4fv(spot.v, false, view(motion)); gl.enableVertexAttribArray(spot.p);
    lines(motion.floor, motion.floorCount, colour("--rule"), gl.LINES);
    lines(motion.path, motion.pathCount, colour("--c1"), gl.LINE_STRIP);
    lines(motion.cross, motion.crossCount, colour("--c9"), gl.LINES);
    gl.uniform1f(spot.flat, 0); gl.enableVertexAttribArray(spot.n);
    const tones = [colour("--c8"), colour("--c7")].map((rgb, i) => rgb.map((value) => (i ? value : 0.35 + 0.5 * value)));
    for (const part of robots[motion.robot]) {
      gl.uniformMatrix4fv(spot.m, false, placed(motion, part.link)); gl.uniform4f(spot.c, ...(part.colour || tones[part.link % 2]), 1);
      gl.bindBuffer(gl.ARRAY_BUFFER, part.p); gl.vertexAttribPointer(spot.p, 3, gl.FLOAT, false, 0, 0);
      gl.bindBuffer(gl.ARRAY_BUFFER, part.n); gl.vertexAttribPointer(spot.n, 3, gl.FLOAT, false, 0, 0);
      gl.drawArrays(gl.TRIANGLES, 0, part.count);
    }
    time.textContent = `${Math.min(now, motion.duration).toFixed(2)} / ${motion.duration.toFixed(2)} s`;
    if (document.activeElement !== slider || running) slider.value = Math.min(now / motion.duration, 1);
  }
  function tick(stamp) {
    const motion = motions[choice.value || 0], step = Math.min((stamp - last) / 1000, 0.1);
    last = stamp;
    if (running) { now += step; if (now > motion.duration + rest) now = 0; }
    draw();
    if (running) requestAnimationFrame(tick);
  }
  const start = () => { last = performance.now(); requestAnimationFrame(tick); };
  const show = () => { if (!running) requestAnimationFrame(draw); };
  const label = () => { play.textContent = running ? "Pause" : "Play"; };
  play.addEventListener("click", () => { running = !running; label(); if (running) start(); });
  slider.addEventListener("input", () => { running = false; label(); now = slider.value * motions[choice.value || 0].duration; requestAnimationFrame(draw); });
  choice.addEventListener("change", () => { now = 0; show(); });
  const fingers = new Map();
  canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); fingers.set(event.pointerId, event); });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    if (fingers.size === 2) {
      const other = [...fingers.values()].find((finger) => finger.pointerId !== event.pointerId);
      const apart = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY) || 1;
      zoom = Math.min(6, Math.max(0.3, zoom * apart(event) / apart(before)));
    } else {
      yaw -= (event.clientX - before.clientX) * 0.008;
      pitch = Math.min(1.5, Math.max(-0.3, pitch + (event.clientY - before.clientY) * 0.008));
    }
    fingers.set(event.pointerId, event); show();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom = Math.min(6, Math.max(0.3, zoom * Math.exp(-event.deltaY * 0.001))); show(); }, { passive: false });
  addEventListener("resize", show);
  label(); start();
})();
