// ---- the sensor: seen from above, and in an upright section ----
const scene = data.scene;
const INK = { copper: "#b87333", rim: "#6e421a", pad: "#f3d9b8", padRim: "#caa675", fixed: "#8792a6", out: "#c0392b", back: "#2c5d9b", ghost: "#7d889c", ink: "#16213a" };
const most = Object.fromEntries(forces.map((force) => [force.name, Math.max(...force.nodes.map(Math.abs)) || 1]));
const toPoints = (list) => list.map((p) => p.map((v) => v.toFixed(4)).join(",")).join(" ");
const toPath = (loops) => loops.map((loop) => "M" + loop.map((p) => p[0].toFixed(4) + " " + (-p[1]).toFixed(4)).join("L") + "Z").join("");
const reaches = (loops) => loops.flat().reduce(([x, y], p) => [Math.max(x, Math.abs(p[0])), Math.max(y, Math.abs(p[1]))], [0, 0]);
const outer = (coil) => coil.reach;

// Where points of the target are: turned by the rotation vector, then shifted; `grow` times the true motion.
function motion(load, grow) {
  const read = (name) => (data.values[name] ? at(data.values[name], load) : 0);
  const all = ["d_h", "d_y", "d_v", "alpha_x", "alpha", "alpha_z"].map(read);
  if (all.some((value) => value === null)) return null;
  const [d_h, d_y, d_v, ...turn] = all.map((value, k) => (k < 3 ? 1e3 * value : value) * grow);
  const angle = Math.hypot(...turn), [a, b, c] = turn.map((v) => v / (angle || 1)), cos = Math.cos(angle), sin = Math.sin(angle), v = 1 - cos;
  const R = [[cos + a * a * v, a * b * v - c * sin, a * c * v + b * sin], [a * b * v + c * sin, cos + b * b * v, b * c * v - a * sin], [a * c * v - b * sin, b * c * v + a * sin, cos + c * c * v]];
  const shift = [d_h, d_y, scene.rest + d_v - grow * scene.rest];
  return { moved: (p) => R.map((row, k) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + shift[k]), slope: [R[2][0], R[2][1]] };
}
const still = { moved: (p) => [p[0], p[1], p[2] + scene.rest], slope: [0, 0] };

function arrowNodes(parent) {
  const group = svgNode("g", { stroke: INK.ink, fill: INK.ink, "stroke-width": 0.07 }, parent), shaft = svgNode("line", {}, group), tip = svgNode("polygon", { stroke: "none" }, group);
  return (tail, u, length) => {
    group.setAttribute("visibility", length > 1e-9 ? "visible" : "hidden");
    const end = [tail[0] + u[0] * length, tail[1] + u[1] * length], n = [-u[1], u[0]];
    for (const [key, value] of Object.entries({ x1: tail[0], y1: tail[1], x2: end[0] - 0.3 * u[0], y2: end[1] - 0.3 * u[1] })) shaft.setAttribute(key, value);
    tip.setAttribute("points", toPoints([end, [0, 1].map((k) => end[k] - 0.42 * u[k] + 0.19 * n[k]), [0, 1].map((k) => end[k] - 0.42 * u[k] - 0.19 * n[k])]));
  };
}

// From where to where a line at an angle through the middle, or beside it, is within closed loops.
function chords(loops, angle, offset = 0) {
  const c = Math.cos(angle), s = Math.sin(angle), found = [];
  for (const loop of loops)
    loop.forEach((p, k) => {
      const q = loop[(k + 1) % loop.length], d = c * p[1] - s * p[0] - offset, e = c * q[1] - s * q[0] - offset;
      if (d > 0 !== e > 0) found.push(c * p[0] + s * p[1] + (d / (d - e)) * (c * (q[0] - p[0]) + s * (q[1] - p[1])));
    });
  found.sort((a, b) => a - b);
  return found.filter((_, k) => k % 2 === 0).map((a, k) => [a, found[2 * k + 1]]);
}

// ---- the plan ----
function planView() {
  const svg = byId("plan"), loops = [...(scene.pad ? scene.pad.loops : []), ...(scene.target ? scene.target.loops : []), ...scene.fixed.flatMap((part) => part.loops)];
  let [x, y] = reaches(loops);
  for (const coil of scene.coils) [x, y] = [Math.max(x, Math.abs(coil.centre[0]) + outer(coil)), Math.max(y, Math.abs(coil.centre[1]) + outer(coil))];
  [x, y] = [1.12 * x + 0.3, 1.12 * y + 0.3];
  svg.setAttribute("viewBox", [-x, -y, 2 * x, 2 * y].join(" "));
  const thin = x / 260, size = x / 13;
  if (scene.pad) svgNode("path", { d: toPath(scene.pad.loops), fill: INK.pad, stroke: INK.padRim, "stroke-width": thin, opacity: 0.75 }, svg);
  if (scene.cover) svgNode("path", { d: toPath(scene.cover.loops), fill: INK.pad, stroke: INK.padRim, "stroke-width": thin, opacity: 0.75 }, svg);
  for (const part of scene.fixed) svgNode("path", { d: toPath(part.loops), fill: INK.fixed, "fill-rule": "evenodd", opacity: 0.5 }, svg);
  const many = scene.coils.length > 9;
  for (const coil of scene.coils) {
    const [cx, cy] = [coil.centre[0], -coil.centre[1]], ring = (r, width, opacity) => svgNode("circle", { cx, cy, r, fill: "none", stroke: INK.back, "stroke-width": width, opacity }, svg);
    for (const line of coil.lines)
      svgNode("path", { d: "M" + line.map((p) => p[0].toFixed(4) + " " + (-p[1]).toFixed(4)).join("L"), fill: "none", stroke: INK.back, "stroke-width": coil.width, opacity: 0.45 }, svg);
    if (!coil.radii.length) continue;
    const inside = coil.radii[0] - coil.width / 2, outside = outer(coil);
    ring((inside + outside) / 2, outside - inside, 0.14);
    if (!many) for (const r of coil.radii) ring(r, coil.width, 0.55);
  }
  const line = svgNode("line", { stroke: INK.ghost, "stroke-width": 1.6 * thin, "stroke-dasharray": [9, 3, 2, 3].map((k) => k * thin * 1.4).join(" ") }, svg);
  const ghost = svgNode("path", { fill: "none", stroke: INK.ghost, "stroke-width": thin, "stroke-dasharray": 5 * thin + " " + 4 * thin }, svg);
  const plate = svgNode("path", { id: "plate-plan", fill: INK.copper, "fill-opacity": 0.5, "fill-rule": "evenodd", stroke: INK.rim, "stroke-width": 1.4 * thin }, svg);
  const cross = svgNode("path", { fill: "none", stroke: INK.rim, "stroke-width": thin }, svg);
  const low = svgNode("circle", { r: 0.3 * size, fill: INK.rim, stroke: "#fff", "stroke-width": thin }, svg);
  const arrow = arrowNodes(svg), edge = { stroke: INK.pad, "stroke-width": 0.2 * size, "paint-order": "stroke" }; // letters over the arrow
  for (const coil of scene.coils)
    svgNode("text", { x: coil.centre[0], y: -coil.centre[1] + 0.35 * size, "font-size": many ? 0.6 * size : size, "text-anchor": "middle", fill: INK.ink, ...edge }, svg).textContent = coil.name;
  return (load, wrench, angle, grow) => {
    const now = motion(load, grow) || still, from = (p) => now.moved([p[0], p[1], 0]).slice(0, 2);
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    for (const [key, value] of Object.entries({ x1: -c * 2 * x, x2: c * 2 * x, y1: s * 2 * x, y2: -s * 2 * x })) line.setAttribute(key, value);
    if (!scene.target) return;
    const [a, b] = reaches(scene.target.loops), [i, j] = [0.12 * a, 0.12 * b];
    ghost.setAttribute("d", toPath(scene.target.loops));
    plate.setAttribute("d", toPath(scene.target.loops.map((loop) => loop.map(from))));
    cross.setAttribute("d", [[[-i, 0], [i, 0]], [[0, -j], [0, j]]].map((ends) => "M" + ends.map(from).map((p) => p[0] + " " + -p[1]).join("L")).join(""));
    // the middle of what lies lowest on the rim: where the target dips
    const dip = Math.hypot(...now.slope), rim = scene.target.loops[0], height = (p) => p[0] * now.slope[0] + p[1] * now.slope[1];
    const least = Math.min(...rim.map(height)), down = rim.filter((p) => height(p) <= least + 0.02 * dip * a);
    low.setAttribute("visibility", dip > 1e-9 ? "visible" : "hidden");
    const [lx, ly] = from([0, 1].map((k) => down.reduce((sum, p) => sum + p[k], 0) / down.length));
    low.setAttribute("cx", lx); low.setAttribute("cy", -ly);
    const shear = [wrench.F_x / (most.F_x || 1), wrench.F_y / (most.F_y || 1)], pull = Math.hypot(...shear), [hx, hy] = from([0, 0]);
    arrow([hx, -hy], [shear[0] / (pull || 1), -shear[1] / (pull || 1)], pull > 1e-9 ? x * (0.12 + 0.3 * Math.min(1, pull)) : 0);
  };
}

// ---- the section ----
function sectionView() {
  const svg = byId("stage"), deep = Math.max(...scene.coils.map((coil) => coil.thickness / 2 - Math.min(...coil.heights)));
  const width = Math.max(...(scene.pad ? scene.pad.loops.flat().map((p) => Math.hypot(...p)) : [0])), flat = !place.has("F_y") && !place.has("M_x");
  const reach = Math.max(scene.pad ? (flat ? reaches(scene.pad.loops)[0] : width) * 1.12 : 0, ...scene.coils.map((coil) => Math.abs(coil.centre[0]) + outer(coil)), ...(scene.target ? reaches(scene.target.loops) : [])) + 0.3;
  const thick = scene.target ? scene.target.thickness : 0, over = scene.cover ? scene.cover.thickness : 0, top = Math.max(scene.rest + thick + over + 2.4, (data.most_high ?? 0) + 0.3), bend = scene.substrate ? reach * reach / scene.substrate / 2 : 0;
  const view = { x: -reach, y: -top, width: 2 * reach, height: top + deep + 0.5 + bend };
  svg.setAttribute("viewBox", [view.x, view.y, view.width, view.height].join(" "));
  svgNode("rect", { x: view.x, y: 0, width: view.width, height: view.y + view.height, fill: "#d9e6dd" }, svg);
  svgNode("line", { x1: view.x, x2: -view.x, y1: 0, y2: 0, stroke: "#9db3a6", "stroke-width": 0.03 }, svg);
  if (data.most_high != null) svgNode("line", { x1: view.x, x2: -view.x, y1: -data.most_high, y2: -data.most_high, stroke: INK.out, "stroke-width": 0.06, "stroke-dasharray": "0.3 0.2", class: "asked" }, svg);
  const bars = svgNode("g", {}, svg), layer = svgNode("path", { fill: INK.pad, stroke: INK.padRim, "stroke-width": 0.04, opacity: 0.92 }, svg);
  const skin = svgNode("path", { fill: INK.pad, stroke: INK.padRim, "stroke-width": 0.04, opacity: 0.92 }, svg);  // its foot drawn at rest
  const ghost = svgNode("path", { fill: "none", stroke: INK.ghost, "stroke-width": 0.05, "stroke-dasharray": "0.18 0.14" }, svg);
  const plate = svgNode("path", { fill: INK.copper, stroke: INK.rim, "stroke-width": 0.04, id: "plate" }, svg), arrow = arrowNodes(svg);
  const bent = ([s, z]) => { const R = scene.substrate; return R ? [(R + z) * Math.sin(s / R), (R + z) * Math.cos(s / R) - R] : [s, z]; };
  const box = (a, b, low, high) => [[a, low], [b, low], [b, high], [a, high]];

  function drawFixed(angle) {
    bars.replaceChildren();
    for (const part of scene.fixed)
      for (const [a, b] of chords(part.loops, angle)) svgNode("path", { d: toPath([box(a, b, part.low, part.high)]), fill: INK.fixed, opacity: 0.8 }, bars);
    for (const coil of scene.coils) {
      const start = Math.cos(angle) * coil.centre[0] + Math.sin(angle) * coil.centre[1], d = Math.cos(angle) * coil.centre[1] - Math.sin(angle) * coil.centre[0];
      const half = coil.thickness / 2, cut = { [INK.out]: [], [INK.back]: [] };
      for (const r of coil.radii) {
        const far = Math.sqrt(Math.max(0, (r + coil.width / 2) ** 2 - d * d)), near = Math.sqrt(Math.max(0, (r - coil.width / 2) ** 2 - d * d));
        if (far > 0) for (const z of coil.heights) for (const [shade, way] of [[INK.out, 1], [INK.back, -1]]) cut[shade].push(box(start + way * near, start + way * far, z - half, z + half).map(bent));
      }
      for (const line of coil.lines)
        line.slice(1).forEach((q, k) => {
          const p = line[k], [e, f] = [p, q].map((v) => Math.cos(angle) * v[1] - Math.sin(angle) * v[0]);
          if (e > 0 === f > 0) return;
          const [s, t] = [p, q].map((v) => Math.cos(angle) * v[0] + Math.sin(angle) * v[1]), far = coil.width / 2 * Math.hypot(t - s, f - e) / Math.abs(f - e), middle = s - e * (t - s) / (f - e);
          cut[f > e ? INK.out : INK.back].push(box(middle - far, middle + far, p[2] - half, p[2] + half).map(bent));
        });
      if (!cut[INK.out].length)  // beside the section: its outline, pale
        svgNode("path", { d: toPath([box(start - outer(coil), start + outer(coil), Math.min(...coil.heights) - half, 0).map(bent)]), fill: INK.fixed, opacity: 0.35 }, bars);
      for (const shade in cut) svgNode("path", { d: toPath(cut[shade]), fill: shade }, bars);
    }
  }
  let drawn = null;
  return (load, wrench, angle, grow) => {
    if (angle !== drawn) drawFixed(angle);
    drawn = angle;
    if (!scene.target) return;
    const c = Math.cos(angle), s = Math.sin(angle), t = scene.target.thickness, now = motion(load, grow) || still;
    const place2 = (how, q, z) => { const p = how.moved([c * q, s * q, z]); return [c * p[0] + s * p[1], p[2]]; };
    const pieces = chords(scene.target.loops, angle), boxes = (how) => pieces.map(([a, b]) => [place2(how, a, 0), place2(how, b, 0), place2(how, b, t), place2(how, a, t)]);
    plate.setAttribute("d", toPath(boxes(now)));
    ghost.setAttribute("d", toPath(boxes(still)));
    if (scene.cover) skin.setAttribute("d", toPath(chords(scene.cover.loops, angle).map(([a, b]) => [place2(still, a, 0), place2(still, b, 0), place2(now, b, t + over), place2(now, a, t + over)])));
    if (!pieces.length) return;
    if (scene.pad) layer.setAttribute("d", chords(scene.pad.loops, angle).map(([from, to]) => {  // bonded where the target is
      const ends = [Math.max(from, pieces[0][0]), Math.min(to, pieces[pieces.length - 1][1])], [left, right] = ends.map((q) => place2(now, q, 0)).map(([q, z]) => [q, -z]);
      const low = -scene.pad.bottom, high = -scene.rest, shift = (left[0] + right[0] - ends[0] - ends[1]) / 2, sink = Math.max(0, (left[1] + right[1]) / 2 - high);
      const edge = 0.35 * shift, out = 0.5 * Math.min(sink, to - from);
      const one = ends[0] > from + 1e-6 ? [from + edge, high, "C", (from + left[0]) / 2, high, (from + left[0]) / 2, left[1], ...left] : left;  // a rim on the layer, or a side that ends at the target
      const other = ends[1] < to - 1e-6 ? ["C", (to + right[0]) / 2, right[1], (to + right[0]) / 2, high, to + edge, high] : [];
      const [a, b] = [one === left ? (from + left[0]) / 2 : from + 0.3 * edge, other.length ? to + 0.3 * edge : (to + right[0]) / 2];
      return ["M", from, low, "Q", a - out, (low + high) / 2, ...one, "L", ...right, ...other, "Q", b + out, (low + high) / 2, to, low, "Z"].join(" ");
    }).join(" "));
    const pull = [(c * wrench.F_x) / (most.F_x || 1) + (s * wrench.F_y) / (most.F_y || 1), wrench.F_z / (most.F_z || 1)], size = Math.hypot(...pull);
    const u = pull.map((v) => v / (size || 1)), length = 1.5 * Math.min(1, 0.35 + 0.65 * size), head = place2(now, 0, t);
    arrow([head[0] - u[0] * (length + 0.08), -head[1] - u[1] * (length + 0.08) - (u[1] < 0.2 ? 0.35 : 0)], u, size > 1e-9 ? length : 0);
  };
}
