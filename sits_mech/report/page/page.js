"use strict";
// The explorer: what the sensor shows between the loads of the table. Values at the table's loads are the table's own;
// between them polynomials of degree three go through the four nearest loads of each force.
(function () {
  const data = JSON.parse(document.getElementById("table").textContent);
  const byId = (name) => document.getElementById(name);
  const svgNode = (tag, attributes, parent) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (parent) parent.appendChild(node);
    return node;
  };

  // ---- interpolation on the table ----
  function weights(nodes, x, count) {
    const n = nodes.length;
    if (n === 1) return [[0, 1]];
    let cell = 0;
    while (cell < n - 2 && x > nodes[cell + 1]) cell += 1;
    const first = Math.max(0, Math.min(n - count, cell - (count - 2) / 2));
    const found = [];
    for (let i = first; i < Math.min(first + count, n); i += 1) {
      let weight = 1;
      for (let j = first; j < Math.min(first + count, n); j += 1)
        if (j !== i) weight *= (x - nodes[j]) / (nodes[i] - nodes[j]);
      if (Math.abs(weight) > 1e-12) found.push([i, weight]);
    }
    return found;
  }
  function sum(values, across, down) {
    let total = 0;
    for (const [i, a] of across)
      for (const [j, b] of down) {
        const value = values[i][j];
        if (value === null) return null;
        total += a * b * value;
      }
    return total;
  }
  function at(values, fx, fz) {
    for (const count of [4, 2]) {
      const found = sum(values, weights(data.F_x, fx, count), weights(data.F_z, fz, count));
      if (found !== null) return found;
    }
    return null;
  }
  window.sensorAt = (name, fx, fz) => at(data.values[name], fx, fz);

  // ---- numbers as they are shown ----
  const shown = (value, digits) => {
    if (value === null) return "–";
    const text = value.toFixed(digits);
    return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
  };
  const digitsFor = (error, most) => {
    if (error === null || !(error > 0)) return most;
    return Math.max(0, Math.min(most, 1 - Math.floor(Math.log10(error))));
  };
  function put(item, fx, fz) {
    const value = at(data.values[item.name], fx, fz);
    const error = item.error ? at(data.values[item.error], fx, fz) : null;
    byId("v-" + item.name).textContent = value === null ? "–" : shown(item.scale * value, item.digits) + " " + item.unit;
    const extra = byId("e-" + item.name);
    if (extra && error !== null)
      extra.textContent = "± " + shown(item.scale * Math.abs(error), digitsFor(item.scale * Math.abs(error), item.digits + 2)) + " " + item.unit;
  }

  // ---- the section through coils, layer and target ----
  const scene = data.scene;
  const stage = byId("stage");
  const view = scene.view;
  stage.setAttribute("viewBox", [view.x, view.y, view.width, view.height].join(" "));
  svgNode("rect", { x: view.x, y: 0, width: view.width, height: view.y + view.height, fill: "#d9e6dd" }, stage);
  svgNode("line", { x1: view.x, x2: view.x + view.width, y1: 0, y2: 0, stroke: "#9db3a6", "stroke-width": 0.03 }, stage);
  for (const part of scene.fixed)
    svgNode("rect", { x: part[0], y: part[1], width: part[2], height: part[3], fill: "#8792a6", opacity: 0.8 }, stage);
  for (const bar of scene.bars)
    svgNode("rect", { x: bar[0], y: bar[1], width: bar[2], height: bar[3], fill: bar[4] > 0 ? "#c0392b" : "#2c5d9b" }, stage);
  const layer = svgNode("path", { fill: "#f3d9b8", stroke: "#caa675", "stroke-width": 0.04, opacity: 0.92 }, stage);
  const ghost = svgNode("polygon", { fill: "none", stroke: "#7d889c", "stroke-width": 0.05, "stroke-dasharray": "0.18 0.14" }, stage);
  const plate = svgNode("polygon", { fill: "#b87333", stroke: "#6e421a", "stroke-width": 0.04, id: "plate" }, stage);
  const arrow = svgNode("g", { stroke: "#16213a", fill: "#16213a", "stroke-width": 0.07 }, stage);
  const shaft = svgNode("line", {}, arrow);
  const tip = svgNode("polygon", { stroke: "none" }, arrow);

  function corners(d_h, d_v, alpha) {
    const half = scene.target.width / 2, t = scene.target.thickness, c = Math.cos(alpha), s = Math.sin(alpha);
    return [[-half, 0], [half, 0], [half, t], [-half, t]].map(([x, z]) => [d_h + x * c + z * s, -(d_v - x * s + z * c)]);
  }
  const points = (list) => list.map((p) => p.join(",")).join(" ");
  function drawScene(fx, fz) {
    const rest = scene.rest, pose = ["d_h", "d_v", "alpha"].map((name) => at(data.values[name], fx, fz));
    const grow = Number(byId("grow").value);
    const known = pose.every((value) => value !== null);
    const [d_h, d_v, alpha] = known ? [1e3 * pose[0] * grow, rest + (1e3 * pose[1] - rest) * grow, pose[2] * grow] : [0, rest, 0];
    const box = corners(d_h, d_v, alpha);
    plate.setAttribute("points", points(box));
    ghost.setAttribute("points", points(corners(0, rest, 0)));
    const w = scene.layer.width / 2, low = -scene.layer.bottom, top = -rest, [left, right] = [box[0], box[1]];
    const edge = 0.35 * d_h, out = 0.5 * Math.max(0, rest - d_v);
    layer.setAttribute("d", [
      "M", -w, low, "Q", -w - out + 0.3 * edge, (low + top) / 2, -w + edge, top,
      "C", (-w + left[0]) / 2, top, (-w + left[0]) / 2, left[1], left[0], left[1], "L", right[0], right[1],
      "C", (w + right[0]) / 2, right[1], (w + right[0]) / 2, top, w + edge, top,
      "Q", w + out + 0.3 * edge, (low + top) / 2, w, low, "Z"].join(" "));
    const size = Math.hypot(fx / scene.force.x, fz / scene.force.z), head = [(box[2][0] + box[3][0]) / 2, (box[2][1] + box[3][1]) / 2];
    arrow.setAttribute("visibility", size > 1e-9 ? "visible" : "hidden");
    if (size > 1e-9) {
      const reach = 1.5 * Math.min(1, 0.35 + 0.65 * size), u = [fx / scene.force.x / size, fz / scene.force.z / size];
      const gap = 0.08, start = [head[0] - u[0] * (reach + gap), head[1] - u[1] * (reach + gap) - (u[1] < 0.2 ? 0.35 : 0)];
      const end = [start[0] + u[0] * reach, start[1] + u[1] * reach], n = [-u[1], u[0]];
      for (const [key, value] of Object.entries({ x1: start[0], y1: start[1], x2: end[0] - 0.3 * u[0], y2: end[1] - 0.3 * u[1] })) shaft.setAttribute(key, value);
      tip.setAttribute("points", points([end, [end[0] - 0.42 * u[0] + 0.19 * n[0], end[1] - 0.42 * u[1] + 0.19 * n[1]], [end[0] - 0.42 * u[0] - 0.19 * n[0], end[1] - 0.42 * u[1] - 0.19 * n[1]]]));
    }
  }

  // ---- curves through the present load ----
  function chart(id, name, along, across, unit) {
    const svg = byId(id), W = 520, H = 300, m = { l: 68, r: 14, t: 12, b: 44 };
    if (!data.items.some((item) => item.name === name) || data[along].length < 2) {
      svg.parentNode.remove();
      return () => {};
    }
    svg.setAttribute("viewBox", "0 0 " + W + " " + H);
    const xs = data[along], family = data[across], values = data.values[name];
    const flat = values.flat().filter((v) => v !== null);
    let lo = Math.min(...flat), hi = Math.max(...flat);
    const room = 0.06 * (hi - lo || 1);
    lo -= room; hi += room;
    const X = (v) => m.l + ((v - xs[0]) / (xs[xs.length - 1] - xs[0] || 1)) * (W - m.l - m.r);
    const Y = (v) => H - m.b - ((v - lo) / (hi - lo)) * (H - m.t - m.b);
    const ticks = (a, b) => {
      const raw = (b - a) / 5, p = Math.pow(10, Math.floor(Math.log10(raw))), step = [1, 2, 2.5, 5, 10].map((k) => k * p).find((k) => k >= raw);
      const found = [];
      for (let k = Math.ceil(a / step - 1e-9); k * step <= b + 1e-9 * step; k += 1) found.push([k * step, Math.max(0, 1 - Math.floor(Math.log10(step)) - (step / p === 2.5 ? 0 : 1))]);
      return found;
    };
    for (const [v, d] of ticks(lo, hi)) {
      svgNode("line", { x1: m.l, x2: W - m.r, y1: Y(v), y2: Y(v), stroke: "#e6eaf1" }, svg);
      svgNode("text", { x: m.l - 8, y: Y(v) + 4, "text-anchor": "end", "font-size": 12, fill: "#5b6780" }, svg).textContent = shown(v, d);
    }
    for (const [v, d] of ticks(xs[0], xs[xs.length - 1])) {
      svgNode("line", { x1: X(v), x2: X(v), y1: m.t, y2: H - m.b, stroke: "#f0f3f7" }, svg);
      svgNode("text", { x: X(v), y: H - m.b + 17, "text-anchor": "middle", "font-size": 12, fill: "#5b6780" }, svg).textContent = shown(v, d);
    }
    svgNode("text", { x: (m.l + W - m.r) / 2, y: H - 8, "text-anchor": "middle", "font-size": 13, fill: "#16213a" }, svg).textContent = (along === "F_z" ? "normal force F_z" : "shear force F_x") + " [N]";
    svgNode("text", { x: 14, y: (H - m.b + m.t) / 2, "text-anchor": "middle", "font-size": 13, fill: "#16213a", transform: "rotate(-90 14 " + (H - m.b + m.t) / 2 + ")" }, svg).textContent = unit;
    const read = (a, b) => (along === "F_z" ? at(values, b, a) : at(values, a, b));
    const path = (other) => {
      let d = "", pen = "M";
      for (let k = 0; k <= 80; k += 1) {
        const x = xs[0] + ((xs[xs.length - 1] - xs[0]) * k) / 80, v = read(x, other);
        if (v === null) { pen = "M"; continue; }
        d += pen + X(x).toFixed(2) + " " + Y(v).toFixed(2);
        pen = "L";
      }
      return d;
    };
    for (const other of family) svgNode("path", { d: path(other), fill: "none", stroke: "#c3cbd9", "stroke-width": 1 }, svg);
    const live = svgNode("path", { fill: "none", stroke: "#0b7285", "stroke-width": 2.4 }, svg);
    const dot = svgNode("circle", { r: 5.5, fill: "#b87333", stroke: "#fff", "stroke-width": 1.6 }, svg);
    return (fx, fz) => {
      const [x, other] = along === "F_z" ? [fz, fx] : [fx, fz], v = read(x, other);
      live.setAttribute("d", path(other));
      dot.setAttribute("visibility", v === null ? "hidden" : "visible");
      if (v !== null) { dot.setAttribute("cx", X(x)); dot.setAttribute("cy", Y(v)); }
    };
  }
  const charts = [chart("chart-v", "L_v_percent", "F_z", "F_x", "L_v [% of L0]"), chart("chart-h", "L_h_percent", "F_x", "F_z", "L_h [% of L0]")];

  // ---- the plane of both forces: shade is L_v, dots are the computed loads ----
  function forcePlane() {
    if (data.F_x.length < 2 || data.F_z.length < 2) {
      byId("pad").remove();
      return () => {};
    }
    const svg = byId("pad"), W = 620, H = 252, m = { l: 58, r: 16, t: 12, b: 40 }, values = data.values.L_v_percent;
    svg.setAttribute("viewBox", "0 0 " + W + " " + H);
    const span = (nodes) => [nodes[0], nodes[nodes.length - 1] > nodes[0] ? nodes[nodes.length - 1] : nodes[0] + 1];
    const [x0, x1] = span(data.F_x), [z0, z1] = span(data.F_z);
    const X = (v) => m.l + ((v - x0) / (x1 - x0)) * (W - m.l - m.r), Z = (v) => H - m.b - ((v - z0) / (z1 - z0)) * (H - m.t - m.b);
    const flat = values.flat().filter((v) => v !== null), lo = Math.min(...flat), hi = Math.max(...flat);
    const across = 48, up = 20, w = (W - m.l - m.r) / across, h = (H - m.t - m.b) / up;
    for (let i = 0; i < across; i += 1)
      for (let j = 0; j < up; j += 1) {
        const v = at(values, x0 + ((x1 - x0) * (i + 0.5)) / across, z0 + ((z1 - z0) * (j + 0.5)) / up);
        const t = v === null ? null : (v - lo) / (hi - lo || 1);
        const fill = t === null ? "#f3d3d3" : "rgb(" + [[11, 236], [114, 242], [133, 226]].map(([a, b]) => Math.round(a + (b - a) * (0.15 + 0.85 * t))).join(",") + ")";
        svgNode("rect", { x: m.l + i * w, y: H - m.b - (j + 1) * h, width: w + 0.4, height: h + 0.4, fill: fill }, svg);
      }
    data.F_x.forEach((x, i) => data.F_z.forEach((z, j) =>
      svgNode("circle", { cx: X(x), cy: Z(z), r: 2.4, fill: values[i][j] === null ? "#a61e28" : "#16213a", opacity: 0.55 }, svg)));
    const text = (attributes, words) => { svgNode("text", Object.assign({ "font-size": 12, fill: "#5b6780", "text-anchor": "middle" }, attributes), svg).textContent = words; };
    for (const v of [x0, (x0 + x1) / 2, x1]) text({ x: X(v), y: H - m.b + 16 }, shown(v, 2));
    for (const v of [z0, (z0 + z1) / 2, z1]) text({ x: m.l - 8, y: Z(v) + 4, "text-anchor": "end" }, shown(v, 2));
    text({ x: (m.l + W - m.r) / 2, y: H - 8, fill: "#16213a" }, "F_x [N]   (shade: L_v, dark is low; dots: computed loads)");
    text({ x: 14, y: (H - m.b + m.t) / 2, fill: "#16213a", transform: "rotate(-90 14 " + (H - m.b + m.t) / 2 + ")" }, "F_z [N]");
    const mark = svgNode("circle", { r: 7, fill: "#b87333", stroke: "#fff", "stroke-width": 2 }, svg);
    function pick(event) {
      const box = svg.getBoundingClientRect(), px = ((event.clientX - box.left) / box.width) * W, pz = ((event.clientY - box.top) / box.height) * H;
      sliders.F_x.value = x0 + ((px - m.l) / (W - m.l - m.r)) * (x1 - x0);
      sliders.F_z.value = z0 + ((H - m.b - pz) / (H - m.t - m.b)) * (z1 - z0);
      update();
    }
    svg.addEventListener("pointerdown", (event) => { svg.setPointerCapture(event.pointerId); pick(event); });
    svg.addEventListener("pointermove", (event) => { if (event.buttons) pick(event); });
    return (fx, fz) => { mark.setAttribute("cx", X(fx)); mark.setAttribute("cy", Z(fz)); };
  }

  // ---- the sliders ----
  const sliders = { F_x: byId("fx"), F_z: byId("fz") };
  const place = forcePlane();
  function tell(fx, fz) {
    let near = null, best = Infinity, onTable = false;
    data.F_x.forEach((x, i) => data.F_z.forEach((z, j) => {
      const away = Math.hypot((x - fx) / scene.force.x, (z - fz) / scene.force.z);
      if (away < best) { best = away; near = [i, j]; }
    }));
    onTable = best < 1e-6;
    const reason = data.reasons[near[0]][near[1]], missing = at(data.values.d_v, fx, fz) === null;
    const state = byId("state");
    state.className = missing ? "bad" : "";
    state.textContent = missing ? "No result here. " + (reason || "A neighbouring load has none.")
      : onTable ? "A load of the table: the numbers are the computed ones." : "Between loads of the table: interpolated.";
  }
  function update() {
    const fx = Number(sliders.F_x.value), fz = Number(sliders.F_z.value);
    byId("fx-out").textContent = shown(fx, 3) + " N";
    byId("fz-out").textContent = shown(fz, 3) + " N";
    for (const item of data.items) put(item, fx, fz);
    drawScene(fx, fz);
    charts.forEach((draw) => draw(fx, fz));
    place(fx, fz);
    tell(fx, fz);
  }
  for (const name of ["F_x", "F_z"]) {
    const nodes = data[name], slider = sliders[name], span = nodes[nodes.length - 1] - nodes[0];
    slider.min = nodes[0];
    slider.max = nodes[nodes.length - 1];
    slider.step = span > 0 ? span / (40 * (nodes.length - 1)) : "any";
    slider.value = data.start[name];
    slider.disabled = span === 0;
    slider.addEventListener("input", update);
  }
  byId("grow").addEventListener("change", update);
  byId("rest").addEventListener("click", () => {
    sliders.F_x.value = data.rest.F_x;
    sliders.F_z.value = data.rest.F_z;
    update();
  });
  byId("snap").addEventListener("click", () => {
    for (const name of ["F_x", "F_z"]) {
      const now = Number(sliders[name].value);
      sliders[name].value = data[name].reduce((a, b) => (Math.abs(b - now) < Math.abs(a - now) ? b : a));
    }
    update();
  });
  update();
})();
