// ---- the explorer: a slider for each component of the load, and all that follows it ----
const sliders = forces.map((force) => byId("s-" + force.name));
const loadNow = () => sliders.map((slider) => Number(slider.value));
window.sensorAt = (name, ...load) => at(data.values[name], load);

function put(item, load) {
  const value = at(data.values[item.name], load), errors = data.values[item.error], error = errors ? at(errors, load) : null;
  byId("v-" + item.name).textContent = value === null ? "–" : shown(item.scale * value, item.digits) + (item.unit ? " " + item.unit : "");
  const extra = byId("e-" + item.name), size = item.scale * Math.abs(error);
  if (extra) extra.textContent = error === null || value === null ? "" : "± " + (size > 0 ? shown(size, digitsFor(size, item.digits + 2)) : "0") + " " + item.unit;
}

function tell(load) {
  const near = forces.map((force, k) => force.nodes.reduce((best, x, i) => (Math.abs(x - load[k]) < Math.abs(force.nodes[best] - load[k]) ? i : best), 0));
  const onTable = forces.every((force, k) => Math.abs(force.nodes[near[k]] - load[k]) < 1e-6 * most[force.name]);
  const reason = data.reasons[near.reduce((sum, i, k) => sum + i * strides[k], 0)], missing = at(data.values.d_v, load) === null, state = byId("state");
  state.className = missing ? "bad" : "";
  state.textContent = missing ? "No result here. " + (reason || "A neighbouring load has none.")
    : onTable ? "A load of the table: the numbers are the table's own." : "Between loads of the table: interpolated.";
}

// The angle of the section from x: along the shear force, folded to one side, or as it is chosen.
function sectionAngle(wrench) {
  const chosen = byId("cut").value;
  if (chosen !== "load") return chosen === "x" ? Math.PI / 2 : 0;
  const angle = Math.hypot(wrench.F_x, wrench.F_y) > 1e-9 ? Math.atan2(wrench.F_y, wrench.F_x) : 0;
  return angle > Math.PI / 2 + 1e-9 ? angle - Math.PI : angle < -Math.PI / 2 + 1e-9 ? angle + Math.PI : angle;
}

function choose(values) {
  for (const [name, value] of Object.entries(values)) sliders[place.get(name)].value = value;
  update();
}
const drawings = [planView(), sectionView()], views = [...data.charts.map(curveChart), forceMap(choose)];
function update() {
  const load = loadNow(), wrench = Object.assign({ F_x: 0, F_y: 0, F_z: 0 }, data.held, Object.fromEntries(forces.map((force, k) => [force.name, load[k]])));
  forces.forEach((force, k) => {
    const words = shown(load[k] * force.scale, force.scale === 1 ? 3 : 2) + " " + force.unit;
    byId("o-" + force.name).textContent = words;
    sliders[k].setAttribute("aria-valuetext", words);
  });
  for (const item of data.items) put(item, load);
  const angle = sectionAngle(wrench), grow = Number(byId("grow").value);
  for (const draw of drawings) draw(load, wrench, angle, grow);
  for (const draw of views) draw(load);
  tell(load);
}

forces.forEach((force, k) => {
  const nodes = force.nodes, slider = sliders[k], span = nodes[nodes.length - 1] - nodes[0];
  slider.min = nodes[0];
  slider.max = nodes[nodes.length - 1];
  const step = span / (40 * (nodes.length - 1) || 1), even = nodes.every((x, i) => Math.abs(x - nodes[0] - 40 * i * step) < 1e-9 * span);
  slider.step = span > 0 && even ? step : "any";
  slider.value = force.start;
  slider.disabled = span === 0;
  slider.addEventListener("input", update);
});
if (!["F_y", "M_x", "M_z"].some((name) => place.has(name) || data.held[name])) byId("cut-box").hidden = true;
for (const name of ["grow", "cut", "map-item", "map-x", "map-y"]) if (byId(name)) byId(name).addEventListener("change", update);
byId("rest").addEventListener("click", () => choose(Object.fromEntries(forces.map((force) => [force.name, force.rest]))));
byId("snap").addEventListener("click", () => {
  const load = loadNow();
  choose(Object.fromEntries(forces.map((force, k) => [force.name, force.nodes.reduce((a, b) => (Math.abs(b - load[k]) < Math.abs(a - load[k]) ? b : a))])));
});
update();
