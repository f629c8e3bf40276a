// ---- the twin: what twin.py does with the same numbers, in its letters, of one wrench or reading at a time ----
//   twin.read([F_x, F_z, M, F_y, M_x, M_z])                L [H] and codes of the coils, flags
//   twin.estimate(L), twin.estimateCodes(codes)            wrench [N, N m], NaN where there is none, flags
//   twin.fault(codes)                                      0, or the flag of a coil that was not read
function twinOf(numbers) {
  const OUTSIDE = 1, IGNORED = 2, UNSOLVED = 4, FAULT_FLAGS = 8, FAULT_FULL = 16, FAULT_ZERO = 32, STEPS = 8, LONGEST = 0.3, REACH = 1.2, SETTLED = 1e-3, EDGE = 1e-5, SAME = 1e-9;
  const clip = (v, end) => Math.min(end, Math.max(-end, v)), largest = (row) => Math.max(...row.map(Math.abs));
  const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
  const even = (v) => { const whole = Math.round(v); return whole - v === 0.5 && whole % 2 ? whole - 1 : whole; };
  const map = (name) => Object.fromEntries(["coefficients", "powers", "base", "low", "high", "columns", "fixed"].map((field) => [field, numbers[name + "_" + field]]));
  const over = map("wrench"), count = numbers.coils.length;

  // T_0 to T_degree at x, and their derivatives.
  function chebyshev(x, degree) {
    const values = [1, x], rates = [0, 1];
    for (let k = 2; k <= degree; k += 1) {
      values.push(2 * x * values[k - 1] - values[k - 2]);
      rates.push(2 * values[k - 1] + 2 * x * rates[k - 1] - rates[k - 2]);
    }
    return [values, rates];
  }

  // The outputs of a map less their base, then if asked their derivatives by each x.
  function at({ powers, coefficients }, x, slopes = false) {
    const tables = x.map((v, i) => chebyshev(v, Math.max(...powers.map((row) => row[i]))));
    const terms = (by) => powers.map((row) => row.reduce((product, k, i) => product * tables[i][Number(i === by)][k], 1));
    return [-1, ...(slopes ? x.keys() : [])].map(terms).map((each) => coefficients.map((row) => dot(row, each)));
  }

  // The s with sum_i slopes_i s_i nearest to `off`, by Q R of the slopes.
  function leastSquares(slopes, off) {
    const Q = slopes.map((column) => [...column]), R = Q.map(() => []), d = Q.length;
    for (let i = 0; i < d; i += 1) {
      R[i][i] = Math.sqrt(dot(Q[i], Q[i]));
      Q[i] = Q[i].map((v) => v / R[i][i]);
      for (let j = i + 1; j < d; j += 1) {
        R[i][j] = dot(Q[i], Q[j]);
        Q[j] = Q[j].map((v, c) => v - R[i][j] * Q[i][c]);
      }
    }
    const found = Q.map((column) => dot(column, off));
    for (let i = d - 1; i >= 0; i -= 1) {
      for (let j = i + 1; j < d; j += 1) found[i] -= R[i][j] * found[j];
      found[i] /= R[i][i];
    }
    return found;
  }

  // Whether a scaled wrench lies where no other one shows the same.
  function isValid(x) {
    const near = (part, v) => part[even(clip(0.5 * (clip(v, 1) + 1), 1) * (part.length - 1))];
    return x.reduce(near, numbers.valid) === 1;
  }

  function read(wrench) {
    const x = over.columns.map((k, i) => (wrench[k] - 0.5 * (over.high[i] + over.low[i])) * (2 / (over.high[i] - over.low[i])));
    const others = over.fixed.map((v, k) => wrench[k] - v).filter((_, k) => !over.columns.includes(k));
    const ignored = others.length > 0 && !(largest(others) <= SAME + EDGE * largest(over.fixed));
    const [change] = at(over, x.map((v) => clip(Number.isNaN(v) ? 0 : v, 1)));
    return {
      L: change.slice(0, count).map((v, c) => v + over.base[c]), codes: change.slice(count).map((v, c) => over.base[count + c] + even(v)),
      flags: (largest(x) <= 1 + EDGE ? 0 : OUTSIDE) + (ignored ? IGNORED : 0),
    };
  }

  function estimated(kind, first, given) {
    if (numbers.no_inverse) throw new Error("guess: " + numbers.no_inverse);
    const guess = map("guess_" + kind), scale = numbers["scale_" + kind], edge = 1 + numbers.margin;
    const scaled = (outputs) => scale.map((s, c) => outputs[first + c] / s);
    const off = scale.map((s, c) => (given[c] - over.base[first + c]) / s);
    const y = numbers["directions_" + kind].map((row) => clip(dot(off, row) + row[count], 1));
    let x = at(guess, y)[0].map((v, i) => v + guess.base[i]), move = [];
    for (let step = 0; step < STEPS; step += 1) {
      const [value, ...slopes] = at(over, x, true).map(scaled);
      move = leastSquares(slopes, off.map((v, c) => v - value[c]));
      x = x.map((v, i) => clip(v + clip(move[i], LONGEST), REACH));
    }
    const left = scaled(at(over, x)[0]).map((v, c) => off[c] - v);
    const good = largest(move) < SETTLED && largest(left) < numbers.residual && isValid(x);
    const wrench = over.fixed.map((v) => (good ? v : NaN));
    over.columns.forEach((k, i) => { wrench[k] = good ? 0.5 * (clip(x[i], edge) * (over.high[i] - over.low[i]) + (over.high[i] + over.low[i])) : NaN; });
    return { wrench, flags: (largest(x) > edge ? OUTSIDE : 0) + (good ? 0 : UNSOLVED) };
  }

  // What is wrong with the first code that is of no coil.
  function fault(codes) {
    const full = 2 ** numbers.bits - 1, wrong = codes.find((code) => code <= 0 || code >= full);
    return wrong === undefined ? 0 : wrong === 0 ? FAULT_ZERO : wrong === full ? FAULT_FULL : FAULT_FLAGS;
  }

  function estimateCodes(codes) {
    const wrong = fault(codes);
    return wrong ? { wrench: over.fixed.map(() => NaN), flags: UNSOLVED + wrong } : estimated("codes", count, codes);
  }
  return { numbers, read, estimate: (L) => estimated("L", 0, L), estimateCodes, fault };
}
