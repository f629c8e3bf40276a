// ---- a sweep: parallel coordinates of its cases, and a slice over two of their columns ----
const INK = { ink: "#16213a", copper: "#b87333" }, columns = data.columns, keys = columns.slice(0, data.keys), size = data.cases.length;
const LINES = 2000, kept = new Map(), held = new Map(); // parts of axes, and numbers at which a slice holds the other keys
const column = (name) => columns.find((each) => each.name === name);
const span = (each) => { const [lo, hi] = range(each.values); return hi > lo ? [lo, hi] : [lo - 0.5, lo + 0.5]; };
const within = (i) => [...kept].every(([name, [lo, hi]]) => { const v = column(name).values[i]; return v !== null && v >= lo && v <= hi; });
const failed = (i) => !["ok", "interpolated", "above tolerance", "not bounded", "beyond data"].includes(word(column("status"), i));
const word = (each, i) => (each.words ? each.words[each.values[i]] : each.values[i] === null ? "–" : String(Number(each.values[i].toPrecision(5))));
const told = (i, of) => "case " + data.cases[i] + ": " + [...keys, of, column("status")].map((each) => each.name + " = " + word(each, i)).join(", ");
const tone = (v, [lo, hi]) => shade(v, lo, lo < 0 && hi > 0 ? hi : hi + 0.35 * (hi - lo)); // the palest would not be seen as a line
const colour = (of, ends, i) => (failed(i) ? "#a61e28" : of.values[i] === null ? "#aab2bd" : tone(of.values[i], ends));
const distinct = (each) => [...new Set(each.values)].filter((v) => v !== null).sort((p, q) => p - q);
// Ends of the cells of a grid about some values: halfway to the next ones.
const cellEnds = (values) => {
  const middles = values.slice(1).map((v, k) => (v + values[k]) / 2), n = values.length;
  return n < 2 ? [values[0] - 0.5, values[0] + 0.5] : [2 * values[0] - middles[0], ...middles, 2 * values[n - 1] - middles[n - 2]];
};
const marks = (each) => each.words ? each.words.map((name, k) => [k, name]) : ticks(...span(each)).map(([v, d]) => [v, Math.abs(v) < 1e-3 && v !== 0 ? v.toExponential(1) : shown(v, d)]);

function parallel(of) {
  const svg = byId("parallel"), axes = [...keys, ...(keys.includes(of) ? [] : [of])], W = 1100, H = 380, t = 40, b = 24, l = 70, r = 90;
  const X = (k) => l + (axes.length > 1 ? (k * (W - l - r)) / (axes.length - 1) : 0), ends = span(of);
  const scales = axes.map((each) => { const [lo, hi] = span(each); return (v) => (v === null ? H - 8 : H - b - ((v - lo) / (hi - lo)) * (H - t - b)); });
  svg.replaceChildren();
  svg.setAttribute("viewBox", "0 0 " + W + " " + H);
  const step = Math.ceil(size / LINES), order = [...Array(size).keys()].filter((i) => i % step === 0 || failed(i)).map((i) => [within(i), !failed(i), i]).sort((p, q) => p[0] - q[0] || p[1] - q[1]);
  for (const [inside, , i] of order) {
    const d = axes.map((each, k) => (k ? "L" : "M") + X(k).toFixed(1) + " " + scales[k](each.values[i]).toFixed(1)).join("");
    const line = svgNode("path", { d, fill: "none", stroke: inside ? colour(of, ends, i) : "#e3e7ee", "stroke-width": inside ? 1.3 : 0.7, opacity: inside ? 0.75 : 0.6 }, svg);
    if (inside) svgNode("title", {}, line).textContent = told(i, of);
  }
  axes.forEach((each, k) => {
    svgNode("line", { x1: X(k), x2: X(k), y1: t, y2: H - b, stroke: INK.ink, "stroke-width": 1.2 }, svg);
    text(svg, { x: X(k), y: 18, fill: INK.ink }, each.label);
    for (const [v, name] of marks(each)) text(svg, { x: X(k) + 6, y: scales[k](v) + 4, "text-anchor": "start", "font-size": 11, stroke: "#fff", "stroke-width": 3, "paint-order": "stroke" }, name);
    const part = kept.get(each.name);
    if (part) svgNode("rect", { x: X(k) - 7, width: 14, y: scales[k](part[1]), height: Math.max(2, scales[k](part[0]) - scales[k](part[1])), fill: "#e8a33d", opacity: 0.55 }, svg);
    const grip = svgNode("rect", { x: X(k) - 14, width: 28, y: t - 6, height: H - t - b + 12, fill: "transparent", style: "cursor: ns-resize; touch-action: none", "data-axis": each.name }, svg);
    grip.addEventListener("pointerdown", (begin) => {
      const box = svg.getBoundingClientRect(), [lo, hi] = span(each), valueAt = (event) => lo + ((H - b - ((event.clientY - box.top) / box.height) * H) / (H - t - b)) * (hi - lo);
      const end = (event) => {
        const ends = [valueAt(begin), valueAt(event)].sort((p, q) => p - q);
        if (ends[1] - ends[0] < 0.01 * (hi - lo)) kept.delete(each.name); else kept.set(each.name, ends);
        draw();
      };
      window.addEventListener("pointerup", end, { once: true });
    });
  });
}

function slicePicture(of) {
  const svg = byId("slice"), x = column(byId("x").value), y = column(byId("y").value), W = 860, H = 460, m = { l: 90, r: 80, t: 14, b: 100 };
  const ends = span(of), cells = data.grid && keys.includes(x) && keys.includes(y) && x !== y, [xs, ys] = [x, y].map((each) => (cells ? cellEnds(distinct(each)) : widened(span(each))));
  const scale = (values, from, to) => (v) => from + ((v - values[0]) / (values[values.length - 1] - values[0])) * (to - from), X = scale(xs, m.l, W - m.r), Y = scale(ys, H - m.b, m.t);
  const cell = (values, v) => { const k = values.findIndex((end) => end > v); return [values[k - 1], values[k]]; };
  svg.replaceChildren();
  svg.setAttribute("viewBox", "0 0 " + W + " " + H);
  for (let i = 0; i < size; i += 1) {
    if (x.values[i] === null || y.values[i] === null || !within(i)) continue;
    if ([...held].some(([name, v]) => name !== x.name && name !== y.name && column(name).values[i] !== v)) continue;
    const fill = colour(of, ends, i), [[left, right], [low, high]] = cells ? [cell(xs, x.values[i]), cell(ys, y.values[i])] : [[], []];
    const node = cells ? svgNode("rect", { x: X(left), y: Y(high), width: X(right) - X(left) + 0.4, height: Y(low) - Y(high) + 0.4, fill }, svg)
      : svgNode("circle", { cx: X(x.values[i]), cy: Y(y.values[i]), r: 5, fill, stroke: "#fff", "stroke-width": 0.8 }, svg);
    svgNode("title", {}, node).textContent = told(i, of);
    node.addEventListener("click", () => { byId("state").textContent = told(i, of); });
  }
  for (const [v, name] of marks(x)) text(svg, { x: X(v), y: H - m.b + 18 }, name);
  for (const [v, name] of marks(y)) text(svg, { x: m.l - 8, y: Y(v) + 4, "text-anchor": "end" }, name);
  text(svg, { x: (m.l + W - m.r) / 2, y: H - m.b + 40, fill: INK.ink }, x.label);
  text(svg, { x: 18, y: (m.t + H - m.b) / 2, fill: INK.ink, transform: "rotate(-90 18 " + (m.t + H - m.b) / 2 + ")" }, y.label);
  const bar = W - m.l - m.r, words = ends.map((v) => (of.words ? of.words[Math.round(v)] : String(Number(v.toPrecision(4)))));
  for (let k = 0; k < 60; k += 1) svgNode("rect", { x: m.l + (bar * k) / 60, y: H - 40, width: bar / 60 + 0.5, height: 11, fill: tone(ends[0] + ((ends[1] - ends[0]) * (k + 0.5)) / 60, ends) }, svg);
  text(svg, { x: m.l, y: H - 12, "text-anchor": "start" }, words[0]);
  text(svg, { x: W - m.r, y: H - 12, "text-anchor": "end" }, words[1]);
  text(svg, { x: m.l + bar / 2, y: H - 12, fill: INK.ink }, of.label + "; failed cases are red");
}

// Of a grid a slider for each key that is not an axis of the slice.
function holders() {
  const box = byId("held");
  box.replaceChildren();
  held.clear();
  for (const each of data.grid ? keys : []) {
    const values = distinct(each);
    if (values.length < 2 || [byId("x").value, byId("y").value].includes(each.name)) continue;
    const label = document.createElement("label"), slider = document.createElement("input"), out = document.createElement("output");
    Object.assign(slider, { type: "range", min: 0, max: values.length - 1, step: 1, value: Math.floor(values.length / 2) });
    slider.style.width = "9rem";
    const hold = () => { held.set(each.name, values[slider.value]); out.textContent = word(each, each.values.indexOf(values[slider.value])); };
    slider.addEventListener("input", () => { hold(); draw(); });
    label.append(each.label + " ", slider, " ", out);
    label.style.marginRight = "1rem";
    box.append(label);
    hold();
  }
}
function draw() {
  const of = column(byId("of").value);
  parallel(of);
  slicePicture(of);
  byId("state").textContent = [...Array(size).keys()].filter(within).length + " of " + size + " cases kept";
}
for (const each of columns) for (const name of ["of", "x", "y"]) byId(name).add(new Option(each.label, each.name));
const several = keys.filter((each) => distinct(each).length > 1).sort((p, q) => (p.words ? 1 : 0) - (q.words ? 1 : 0)), first = columns[data.keys] || keys[0];
byId("of").value = (columns.find((each, k) => k >= data.keys && each.name.startsWith("relative")) || first).name;
byId("x").value = (several[0] || keys[0]).name;
byId("y").value = (several[1] || first).name;
for (const name of ["x", "y"]) byId(name).addEventListener("change", () => { holders(); draw(); });
byId("of").addEventListener("change", draw);
holders();
draw();
