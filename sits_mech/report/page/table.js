// ---- the table: any number of components of the load, the last one running fastest ----
// Values at the table's loads are the table's own; between them polynomials of degree three go through the four
// nearest values of each component, or straight lines through two where one of the four has no result.
const data = JSON.parse(document.getElementById("table").textContent);
const forces = data.forces;
const strides = forces.map((_, k) => forces.slice(k + 1).reduce((size, force) => size * force.nodes.length, 1));
const place = new Map(forces.map((force, k) => [force.name, k]));

function weights(nodes, x, count) {
  const n = nodes.length;
  if (n === 1) return [[0, 1]];
  let cell = 0;
  while (cell < n - 2 && x > nodes[cell + 1]) cell += 1;
  const first = Math.max(0, Math.min(n - count, cell - (count - 2) / 2)), found = [];
  for (let i = first; i < Math.min(first + count, n); i += 1) {
    let weight = 1;
    for (let j = first; j < Math.min(first + count, n); j += 1)
      if (j !== i) weight *= (x - nodes[j]) / (nodes[i] - nodes[j]);
    if (Math.abs(weight) > 1e-12) found.push([i, weight]);
  }
  return found;
}

// Sum over the stencils of the components from k on, from an offset into the flat values; null where one is missing.
function total(values, stencils, k, offset) {
  if (k === stencils.length) return values[offset];
  let sum = 0;
  for (const [i, weight] of stencils[k]) {
    const value = total(values, stencils, k + 1, offset + i * strides[k]);
    if (value === null) return null;
    sum += weight * value;
  }
  return sum;
}

// The value at a load; of components with a number in `kept` that value of the table itself is taken.
function at(values, load, kept = {}) {
  for (const count of [4, 2]) {
    const stencils = forces.map((force, k) => (force.name in kept ? [[kept[force.name], 1]] : weights(force.nodes, load[k], count)));
    const found = total(values, stencils, 0, 0);
    if (found !== null) return found;
  }
  return null;
}

// The values over one or two components, the others at a load: numbers on the table's own values of these.
function slice(values, load, first, second) {
  const rows = forces[place.get(first)].nodes.map((_, i) => second
    ? forces[place.get(second)].nodes.map((__, j) => at(values, load, { [first]: i, [second]: j }))
    : at(values, load, { [first]: i }));
  return rows;
}

function onLine(nodes, values, x) {
  for (const count of [4, 2]) {
    let sum = 0;
    for (const [i, weight] of weights(nodes, x, count)) sum = sum === null || values[i] === null ? null : sum + weight * values[i];
    if (sum !== null) return sum;
  }
  return null;
}

const range = (values) => values.reduce(([lo, hi], v) => (v === null ? [lo, hi] : [Math.min(lo, v), Math.max(hi, v)]), [Infinity, -Infinity]);

// ---- numbers as they are shown, and nodes of the page ----
const byId = (name) => document.getElementById(name);
const shown = (value, digits) => {
  if (value === null) return "–";
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
};
const digitsFor = (error, most) => (error === null || !(error > 0) ? most : Math.max(0, Math.min(most, 1 - Math.floor(Math.log10(error)))));
function svgNode(tag, attributes, parent) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const key in attributes) node.setAttribute(key, attributes[key]);
  if (parent) parent.appendChild(node);
  return node;
}
function ticks(a, b, count = 5) {
  const raw = (b - a) / count, p = Math.pow(10, Math.floor(Math.log10(raw))), step = [1, 2, 2.5, 5, 10].map((k) => k * p).find((k) => k >= raw * (1 - 1e-9));
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9) + (Math.abs(step / p - 2.5) < 1e-9 ? 1 : 0)), found = [];
  for (let k = Math.ceil(a / step - 1e-9); k * step <= b + 1e-9 * step; k += 1) found.push([k * step, digits]);
  return found;
}
const text = (svg, attributes, words) => { svgNode("text", Object.assign({ "font-size": 12, fill: "#5b6780", "text-anchor": "middle" }, attributes), svg).textContent = words; };
const axisName = (force) => force.name + " [" + force.unit + "]";
const widened = ([lo, hi]) => [lo - 0.06 * (hi - lo || 1), hi + 0.06 * (hi - lo || 1)];
// Grid, numbers and names of the axes of a chart of a width and a height; returns where values of x and of y are.
function axes(svg, [W, H], [x0, x1], [lo, hi], across, up) {
  const m = { l: 72, r: 12, t: 12, b: 44 }, X = (v) => m.l + ((v - x0) / (x1 - x0)) * (W - m.l - m.r), Y = (v) => H - m.b - ((v - lo) / (hi - lo)) * (H - m.t - m.b);
  svg.setAttribute("viewBox", "0 0 " + W + " " + H);
  for (const [v, d] of ticks(lo, hi)) {
    svgNode("line", { x1: m.l, x2: W - m.r, y1: Y(v), y2: Y(v), stroke: "#e6eaf1" }, svg);
    text(svg, { x: m.l - 8, y: Y(v) + 4, "text-anchor": "end" }, shown(v, d));
  }
  for (const [v, d] of ticks(x0, x1)) {
    svgNode("line", { x1: X(v), x2: X(v), y1: m.t, y2: H - m.b, stroke: "#f0f3f7" }, svg);
    text(svg, { x: X(v), y: H - m.b + 17 }, shown(v, d));
  }
  text(svg, { x: (m.l + W - m.r) / 2, y: H - 6, fill: INK.ink }, across);
  text(svg, { x: 14, y: (H - m.b + m.t) / 2, fill: INK.ink, transform: "rotate(-90 14 " + (H - m.b + m.t) / 2 + ")" }, up);
  return [X, Y];
}
