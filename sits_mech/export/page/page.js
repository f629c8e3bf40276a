// ---- the page: forces that are dragged, what the twin reads, and the forces back from it ----
const WRENCH = ["F_x", "F_z", "M", "F_y", "M_x", "M_z"], SHADES = ["#1098ad", "#e8590c", "#845ef7", "#37b24d", "#e64980", "#b08900", "#228be6", "#868e96"];
const BEYOND = 0.25, STEP = 1 / 40, EACH = 100, KEPT = 200; // shares of a range; milliseconds between samples, how many are kept
const twin = twinOf(data.twin), numbers = data.twin, coils = numbers.coils;
window.twin = twin;
const sliders = forces.map((force) => byId("s-" + force.name)), low = forces.map((force) => force.nodes[0]), high = forces.map((force) => force.nodes[force.nodes.length - 1]);
const rest = forces.map((force) => force.rest), inside = (load) => load.map((v, k) => Math.min(high[k], Math.max(low[k], v)));
const hasCodes = numbers.codes === 1, shade = (c) => SHADES[c % SHADES.length];
const PREFIXES = [["", 1], ["m", 1e-3], ["µ", 1e-6], ["n", 1e-9]];
const prefixed = (value, unit) => { const [prefix, size] = PREFIXES.find(([, size]) => Math.abs(value) >= size) || PREFIXES[3]; return shown(value / size, 2) + " " + prefix + unit; };
const grouped = (value) => shown(value, 0).replace(/\B(?=(\d{3})+$)/g, "\u202f");
const words = (force, value) => shown(value * force.scale, force.scale === 1 ? 3 : 2) + " " + force.unit;
const varied = numbers.wrench_columns.map((k) => WRENCH[k]);
let load = forces.map((force) => force.start), moved = varied.includes("F_z") ? "F_z" : varied[0], seen = null;
const samples = [];

function wrenchOf(load) {
  const wrench = [...numbers.wrench_fixed];
  forces.forEach((force, k) => { wrench[WRENCH.indexOf(force.name)] = load[k]; });
  return wrench;
}

// What is read: codes, with the converter's noise if it is on; inductances where there are no codes.
function sampled() {
  const { L, codes } = seen, normal = () => Math.sqrt(-2 * Math.log(1 - Math.random())) * Math.cos(2 * Math.PI * Math.random());
  if (!hasCodes) return L;
  return byId("noise").checked ? codes.map((code, c) => Math.round(code - (code + numbers.below[c]) * 0.5 * numbers.sigma_L[c] * normal())) : codes;
}

function readOut() {
  const now = sampled();
  if (hasCodes) now.forEach((code, c) => { byId("v-code" + c).textContent = grouped(code); });
  const back = numbers.no_inverse ? null : hasCodes ? twin.estimateCodes(now) : twin.estimate(now);
  forces.forEach((force, k) => {
    const box = byId("b-" + force.name);
    if (!back || !box) return;
    const found = back.wrench[WRENCH.indexOf(force.name)];
    box.className = back.flags ? "bad" : "";
    box.textContent = Number.isNaN(found) ? "no answer" : words(force, found);
    byId("off-" + force.name).textContent = Number.isNaN(found) ? "" : prefixed(found - load[k], force.scale === 1 ? "N" : "N m") + " off";
  });
  tell(back);
  return now;
}

function tell(back) {
  const said = [], missing = at(data.values.d_v, inside(load)) === null;
  if (seen.flags & 1) said.push("Beyond the calibrated range: readings are those at its edge.");
  if (seen.flags & 2) said.push("A force that the calibration holds is ignored.");
  if (back && back.flags & 4) said.push("No single wrench shows this reading.");
  else if (back && back.flags & 1) said.push("The reading lies beyond the calibrated range: the estimate is held at its edge.");
  if (missing) said.push("No pose is known at this load.");
  byId("state").className = said.length ? "bad" : "";
  byId("state").textContent = said.length ? said.join(" ") : numbers.no_inverse ? "Within the calibrated range. No forces back: " + numbers.no_inverse : "Within the calibrated range.";
}

// ---- charts, as wide as they stand on the page ----
const sizeOf = (svg) => [svg.clientWidth || 420, svg.clientHeight || 220];
const line = (X, Y, points) => points.map(([x, y], k) => (k ? "L" : "M") + X(x).toFixed(1) + " " + Y(y).toFixed(1)).join("");

function strip() {
  const svg = byId("strip"), still = twin.read(wrenchOf(rest)), from = hasCodes ? still.codes : still.L, unit = hasCodes ? 1 : 1e9;
  const rows = coils.map((_, c) => samples.map((each, k) => [(k + 1 - samples.length) * EACH / 1e3, (each[c] - from[c]) * unit]));
  const flat = range(rows.flat().map((point) => point[1])), least = hasCodes ? 40 : 0.01, extra = Math.max(0, least - (flat[1] - flat[0])) / 2;
  const thousands = hasCodes && Math.max(-flat[0], flat[1]) >= 1e4 ? 1e-3 : 1, span = widened([flat[0] - extra, flat[1] + extra]).map((v) => v * thousands);
  svg.replaceChildren();
  const [X, Y] = axes(svg, sizeOf(svg), [-EACH * KEPT / 1e3, 0], span, "time [s]", hasCodes ? "change of code" + (thousands === 1 ? "" : " [1000]") : "change of L [nH]");
  rows.forEach((row, c) => svgNode("path", { d: line(X, Y, row.map(([t, v]) => [t, v * thousands])), fill: "none", stroke: shade(c), "stroke-width": 1.8, "stroke-linejoin": "round" }, svg));
}

function curves() {
  const k = place.get(moved), force = forces[k], kept = inside(load), xs = Array.from({ length: 41 }, (_, i) => low[k] + ((high[k] - low[k]) * i) / 40);
  const readings = xs.map((x) => twin.read(wrenchOf(kept.map((v, j) => (j === k ? x : v)))).L);
  coils.forEach((name, c) => {
    const svg = byId("curve" + c), points = xs.map((x, i) => [x * force.scale, readings[i][c] * 1e6]);
    svg.replaceChildren();
    const [X, Y] = axes(svg, sizeOf(svg), [points[0][0], points[40][0]], widened(range(points.map((point) => point[1]))), axisName(force), "L of " + name + " [µH]");
    svgNode("path", { d: line(X, Y, points), fill: "none", stroke: shade(c), "stroke-width": 2.4 }, svg);
    svgNode("circle", { cx: X(kept[k] * force.scale), cy: Y(seen.L[c] * 1e6), r: 5.5, fill: INK.copper, stroke: "#fff", "stroke-width": 1.6 }, svg);
  });
}

// ---- the drawings, which are dragged ----
const drawings = [planView(), sectionView()];
function draw() {
  const kept = inside(load), wrench = Object.fromEntries(WRENCH.map((name, k) => [name, wrenchOf(load)[k]]));
  for (const each of drawings) each(kept, wrench, byId("cut").value === "x" ? Math.PI / 2 : 0, Number(byId("grow").value));
}

function update() {
  seen = twin.read(wrenchOf(load));
  forces.forEach((force, k) => {
    sliders[k].value = load[k];
    byId("o-" + force.name).textContent = words(force, load[k]);
    sliders[k].setAttribute("aria-valuetext", words(force, load[k]));
  });
  seen.L.forEach((L, c) => { byId("v-L" + c).textContent = shown(1e6 * L, 5) + " µH"; });
  for (const item of data.items) {
    const value = at(data.values[item.name], inside(load));
    byId("v-" + item.name).textContent = value === null ? "–" : shown(item.scale * value, item.digits) + " " + item.unit;
  }
  draw();
  curves();
  readOut();
}

// Move forces by shares of their range, at most a little beyond it.
function move(from, shares) {
  load = load.map((v, k) => {
    const share = shares[forces[k].name], span = high[k] - low[k];
    return share === undefined ? v : Math.min(high[k] + BEYOND * span, Math.max(low[k] - BEYOND * span, from[k] + share * span));
  });
  const most = Object.keys(shares).filter((name) => varied.includes(name)).sort((a, b) => Math.abs(shares[b]) - Math.abs(shares[a]))[0];
  if (shares[most]) moved = most;
  update();
  keep();
}

function draggable(svg, forcesOf) {
  let start = null;
  svg.addEventListener("pointerdown", (event) => {
    start = { x: event.clientX, y: event.clientY, load };
    svg.setPointerCapture(event.pointerId);
  });
  svg.addEventListener("pointermove", (event) => {
    if (!start) return;
    const across = svg.clientWidth, [right, down] = forcesOf();
    move(start.load, { [right[0]]: right[1] * (event.clientX - start.x) / across / 0.6, [down[0]]: down[1] * (event.clientY - start.y) / across / 0.3 });
  });
  for (const end of ["pointerup", "pointercancel"]) svg.addEventListener(end, () => { start = null; });
  svg.addEventListener("keydown", (event) => {
    const way = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowDown: [1, 1], ArrowUp: [1, -1] }[event.key];
    if (!way) return;
    event.preventDefault();
    const [name, sign] = forcesOf()[way[0]];
    move(load, { [name]: sign * way[1] * STEP });
  });
}
draggable(byId("stage"), () => [[byId("cut").value === "x" ? "F_y" : "F_x", 1], ["F_z", 1]]);
draggable(byId("plan"), () => [["F_x", 1], ["F_y", -1]]);

// ---- the load in the address ----
let waiting = 0;
function keep() {
  clearTimeout(waiting);
  waiting = setTimeout(() => history.replaceState(null, "", "#" + forces.map((force, k) => force.name + "=" + Number(load[k].toPrecision(6))).join("&")), 200);
}
function restore() {
  const given = new URLSearchParams(location.hash.slice(1));
  load = load.map((v, k) => { const value = given.get(forces[k].name); return value === null || value === "" || !Number.isFinite(Number(value)) ? v : Number(value); });
  update();
}

forces.forEach((force, k) => {
  Object.assign(sliders[k], { min: low[k], max: high[k], step: (high[k] - low[k]) / 200 || "any", disabled: low[k] === high[k] });
  sliders[k].addEventListener("input", () => { load = load.map((v, j) => (j === k ? Number(sliders[k].value) : v)); moved = force.name; update(); keep(); });
});
byId("rest").addEventListener("click", () => { load = rest; update(); keep(); });
byId("noise").disabled = !hasCodes;
byId("noise").addEventListener("change", update);
byId("cut-box").hidden = !place.has("F_y") && !place.has("M_x");
for (const name of ["grow", "cut"]) byId(name).addEventListener("change", draw);
coils.forEach((name, c) => { const key = document.createElement("b"); key.textContent = name; key.style.color = shade(c); byId("legend").append(key); });
window.addEventListener("resize", update);
window.addEventListener("hashchange", restore);
restore();
setInterval(() => {
  samples.push(readOut());
  if (samples.length > KEPT) samples.shift();
  strip();
}, EACH);
