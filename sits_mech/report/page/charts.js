// ---- curves of a signal along its own force, and maps of anything over two components ----
const named = new Map(data.items.map((item) => [item.name, item]));

function curveChart(curve, number) {
  const svg = byId("chart" + number);
  const item = named.get(curve.name), values = data.values[curve.name], force = forces[place.get(curve.along)], family = curve.family ? forces[place.get(curve.family)] : null;
  const xs = force.nodes.map((x) => x * force.scale), flat = range(curve.limit === undefined ? values : [...values, curve.limit]).map((v) => v * item.scale);
  const ends = [xs[0], xs[xs.length - 1]], wanted = (data.asked?.[curve.along] ?? []).map((x) => x * force.scale), seen = range([...ends, ...wanted]), high = widened(flat);
  const [X, Y] = axes(svg, [420, 260], seen, high, axisName(force), curve.axis);
  const line = (x, y) => svgNode("line", { x1: X(x[0]), x2: X(x[1]), y1: Y(y[0]), y2: Y(y[1]), stroke: INK.out, "stroke-width": 1.4, "stroke-dasharray": "6 4", class: "asked" }, svg);
  for (const x of wanted) line([x, x], high);
  if (curve.limit !== undefined) line(seen, [curve.limit * item.scale, curve.limit * item.scale]);
  const others = (family ? family.nodes : []).map(() => svgNode("path", { fill: "none", stroke: "#c3cbd9", "stroke-width": 1 }, svg));
  const live = svgNode("path", { fill: "none", stroke: "#0b7285", "stroke-width": 2.4 }, svg), dot = svgNode("circle", { r: 5.5, fill: INK.copper, stroke: "#fff", "stroke-width": 1.6 }, svg);
  function path(line) {
    const found = [];
    let up = true;
    for (let k = 0; k <= 60; k += 1) {
      const x = force.nodes[0] + ((force.nodes[force.nodes.length - 1] - force.nodes[0]) * k) / 60, v = onLine(force.nodes, line, x);
      if (v === null) { up = true; continue; }
      found.push((up ? "M" : "L") + X(x * force.scale).toFixed(1) + " " + Y(v * item.scale).toFixed(1));
      up = false;
    }
    return found.join("");
  }
  return (load) => {
    others.forEach((node, j) => node.setAttribute("d", path(force.nodes.map((_, i) => at(values, load, { [force.name]: i, [family.name]: j })))));
    live.setAttribute("d", path(slice(values, load, force.name)));
    const v = at(values, load), x = load[place.get(force.name)];
    dot.setAttribute("visibility", v === null ? "hidden" : "visible");
    if (v !== null) { dot.setAttribute("cx", X(x * force.scale)); dot.setAttribute("cy", Y(v * item.scale)); }
  };
}

const mix = (from, to, t) => "rgb(" + from.map((a, k) => Math.round(a + (to[k] - a) * Math.min(1, Math.max(0, t)))).join(",") + ")";
const ONE_SIDED = [[11, 72, 92], [236, 244, 226]], COLD = [28, 93, 153], PALE = [246, 246, 243], WARM = [170, 92, 30];
// Shade of a number within its range: from dark to pale; of one that changes its sign, blue below zero and copper above.
function shade(v, lo, hi) {
  if (v === null) return "#f3d3d3";
  if (lo < 0 && hi > 0 && Math.min(-lo, hi) > 0.05 * (hi - lo)) {
    const t = v / Math.max(-lo, hi);
    return t < 0 ? mix(PALE, COLD, -t) : mix(PALE, WARM, t);
  }
  return mix(ONE_SIDED[0], ONE_SIDED[1], (v - lo) / (hi - lo || 1));
}

// A map of one readout over two components; the others stand at their sliders. Returns what draws it anew.
function forceMap(choose) {
  const several = forces.filter((force) => force.nodes.length > 1), box = byId("map-box");
  if (several.length < 2) { box.remove(); return () => {}; }
  const svg = byId("map"), W = 520, H = 500, m = { l: 76, r: 22, t: 14, b: 112 }, big = { "font-size": 17 }, across = 40, up = 32;
  const what = byId("map-item"), axes = [byId("map-x"), byId("map-y")];
  svg.setAttribute("viewBox", "0 0 " + W + " " + H);
  for (const item of data.items) what.add(new Option(item.label, item.name));
  for (const axis of axes) for (const force of several) axis.add(new Option(force.name, force.name));
  what.value = data.items.find((item) => item.unit === "%").name;
  axes[0].value = several[0].name;
  axes[1].value = several[1].name;
  const cells = [], frame = svgNode("g", { "shape-rendering": "crispEdges" }, svg), w = (W - m.l - m.r) / across, h = (H - m.t - m.b) / up;
  for (let i = 0; i < across; i += 1) for (let j = 0; j < up; j += 1) cells.push(svgNode("rect", { x: m.l + i * w, y: H - m.b - (j + 1) * h, width: w + 0.5, height: h + 0.5 }, frame));
  const notes = svgNode("g", {}, svg), mark = svgNode("circle", { r: 8, fill: INK.ink, stroke: "#fff", "stroke-width": 2.4 }, svg);
  let pair = null, known = "", X = null, Y = null;
  function pick(event) {
    const rect = svg.getBoundingClientRect(), px = ((event.clientX - rect.left) / rect.width) * W, py = ((event.clientY - rect.top) / rect.height) * H;
    const shares = [(px - m.l) / (W - m.l - m.r), (H - m.b - py) / (H - m.t - m.b)];
    choose(Object.fromEntries(pair.map((force, k) => [force.name, force.nodes[0] + Math.min(1, Math.max(0, shares[k])) * (force.nodes[force.nodes.length - 1] - force.nodes[0])])));
  }
  svg.addEventListener("pointerdown", pick);
  svg.addEventListener("pointermove", (event) => { if (event.buttons) pick(event); });
  function draw(load) {
    const item = named.get(what.value), values = data.values[what.value], [fx, fy] = pair, rows = slice(values, load, fx.name, fy.name), every = range(rows.flat());
    const [lo, hi] = every[0] > every[1] ? [0, 1] : every, ends = (force) => [force.nodes[0], force.nodes[force.nodes.length - 1]];
    const [[x0, x1], [y0, y1]] = pair.map(ends);
    X = (v) => m.l + ((v - x0) / (x1 - x0)) * (W - m.l - m.r);
    Y = (v) => H - m.b - ((v - y0) / (y1 - y0)) * (H - m.t - m.b);
    const columns = [];
    for (let i = 0; i < across; i += 1) columns.push(fy.nodes.map((_, j) => onLine(fx.nodes, rows.map((row) => row[j]), x0 + ((x1 - x0) * (i + 0.5)) / across)));
    for (let i = 0; i < across; i += 1) for (let j = 0; j < up; j += 1) cells[i * up + j].setAttribute("fill", shade(onLine(fy.nodes, columns[i], y0 + ((y1 - y0) * (j + 0.5)) / up), lo, hi));
    notes.replaceChildren();
    fx.nodes.forEach((x, i) => fy.nodes.forEach((y, j) => svgNode("circle", { cx: X(x), cy: Y(y), r: 2.4, fill: rows[i][j] === null ? "#a61e28" : INK.ink, opacity: 0.5 }, notes)));
    for (const [v, d] of ticks(x0 * fx.scale, x1 * fx.scale)) text(notes, { ...big, x: X(v / fx.scale), y: H - m.b + 22 }, shown(v, d));
    for (const [v, d] of ticks(y0 * fy.scale, y1 * fy.scale)) text(notes, { ...big, x: m.l - 8, y: Y(v / fy.scale) + 6, "text-anchor": "end" }, shown(v, d));
    text(notes, { ...big, x: (m.l + W - m.r) / 2, y: H - m.b + 46, fill: INK.ink }, axisName(fx));
    text(notes, { ...big, x: 20, y: (H - m.b + m.t) / 2, fill: INK.ink, transform: "rotate(-90 20 " + (H - m.b + m.t) / 2 + ")" }, axisName(fy));
    const bar = W - m.l - m.r, steps = 60, digits = digitsFor(((hi - lo) * item.scale) / 50, item.digits);
    for (let k = 0; k < steps; k += 1) svgNode("rect", { x: m.l + (bar * k) / steps, y: H - 44, width: bar / steps + 0.5, height: 12, fill: shade(lo + ((hi - lo) * (k + 0.5)) / steps, lo, hi) }, notes);
    text(notes, { ...big, x: m.l, y: H - 12, "text-anchor": "start" }, shown(lo * item.scale, digits));
    text(notes, { ...big, x: W - m.r, y: H - 12, "text-anchor": "end" }, shown(hi * item.scale, digits));
    text(notes, { ...big, x: m.l + bar / 2, y: H - 12, fill: INK.ink }, item.label + (item.unit ? " [" + item.unit + "]" : ""));
    svg.setAttribute("aria-label", "Map of " + item.label + " over " + fx.name + " and " + fy.name + ", from " + shown(lo * item.scale, digits) + " to " + shown(hi * item.scale, digits) + " " + item.unit);
  }
  return (load) => {
    if (axes[0].value === axes[1].value) axes[1].value = several.find((force) => force.name !== axes[0].value).name;
    pair = axes.map((axis) => forces[place.get(axis.value)]);
    const key = [what.value, ...axes.map((axis) => axis.value), ...load.filter((_, k) => !pair.includes(forces[k]))].join(" ");
    if (key !== known) draw(load);
    known = key;
    const [x, y] = pair.map((force) => load[place.get(force.name)]);
    mark.setAttribute("cx", X(x));
    mark.setAttribute("cy", Y(y));
  };
}
