(() => {
  "use strict";
  // Interactive figures: closed forms evaluated while sliders move.
  const TURN = 2 * Math.PI, COUNT = 240, SCAN = 1440, DEEPEST = 14;
  const NODES = [0.1834346424956498, 0.525532409916329, 0.7966664774136267, 0.9602898564975363];
  const WEIGHTS = [0.362683783378362, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763];
  const WIDE = 320, HIGH = 200, LEFT = 62, LOW = 162;

  // ---- numerics ----
  const gauss = (f, low, high) => {
    const middle = (low + high) / 2, half = (high - low) / 2;
    return half * NODES.reduce((sum, x, k) => sum + WEIGHTS[k] * (f(middle - half * x) + f(middle + half * x)), 0);
  };
  const integral = (f, low, high, all = gauss(f, low, high), depth = 0) => {
    const middle = (low + high) / 2, left = gauss(f, low, middle), right = gauss(f, middle, high);
    if (depth > DEEPEST || Math.abs(left + right - all) <= 1e-13 * Math.abs(all)) return left + right;
    return integral(f, low, middle, left, depth + 1) + integral(f, middle, high, right, depth + 1);
  };
  // Returns a root of f between `inside`, where f is not negative, and `outside`, where f is negative.
  const root = (f, inside, outside) => {
    for (let k = 0; k < 200; k += 1) {
      const middle = (inside + outside) / 2;
      if (middle === inside || middle === outside) break;
      if (f(middle) >= 0) inside = middle; else outside = middle;
    }
    return inside;
  };

  // Returns one rotation or libration of a body with moment of inertia I in V = -a sin^2 - b sin - c cos.
  const swung = ({a, b, c, inertia, theta, rate}) => {
    const scale = Math.abs(a) + Math.abs(b) + Math.abs(c);
    const potential = (x) => -(a * Math.sin(x) + b) * Math.sin(x) - c * Math.cos(x);
    const slope = (x) => c * Math.sin(x) - (2 * a * Math.sin(x) + b) * Math.cos(x);
    const energy = potential(theta) + inertia * rate * rate / 2;
    // V(x) - V(x + gap) as products, which lose no digits if the gap is small.
    const drop = (x, gap) => {
      const d = -2 * Math.sin(gap / 2), m = x + gap / 2, cosine = d * Math.cos(m);
      return c * d * Math.sin(m) - cosine * (a * (Math.sin(x) + Math.sin(x + gap)) + b);
    };
    const kinetic = (x) => inertia * rate * rate / 2 + drop(theta, x - theta);
    let barrier = -Infinity;
    for (let k = 0; k < SCAN; k += 1) {
      const x = k * TURN / SCAN, y = (k + 1) * TURN / SCAN;
      if (slope(x) >= 0 && slope(y) < 0) barrier = Math.max(barrier, potential(root(slope, x, y)));
    }
    if (!scale) barrier = 0;
    const points = {energy, barrier, potential, theta: [], time: [0], speed: []};
    if (!rate && Math.abs(slope(theta)) <= 1e-14 * scale) return {...points, kind: "at rest", period: 0};
    if (Math.abs(energy - barrier) <= 1e-10 * scale) return {...points, kind: "on the separatrix, which takes for ever", period: Infinity};
    const rate_of = (energy_there) => Math.sqrt(2 * Math.max(energy_there, 0) / inertia);
    const turns = energy > barrier;
    let place, start, pace, speed;
    if (turns) {
      const sign = Math.sign(rate);
      [start, place, pace] = [0, (s) => theta + sign * s, (s) => 1 / rate_of(kinetic(theta + sign * s))];
      speed = (s) => sign * rate_of(kinetic(place(s)));
    } else {
      const end = (sign) => {
        let x = theta;
        while (kinetic(x + sign * TURN / SCAN) >= 0) x += sign * TURN / SCAN;
        return root(kinetic, x, x + sign * TURN / SCAN);
      };
      const low = end(-1), high = end(1), middle = (low + high) / 2, half = (high - low) / 2;
      const from = Math.asin(Math.max(-1, Math.min(1, (theta - middle) / half)));
      start = rate < 0 ? Math.PI - from : from;
      place = (s) => middle + half * Math.sin(s);
      // The speed at a distance of half (1 - |sin s|) from the nearer end.
      const size = (s) => {
        const sign = Math.sin(s) < 0 ? -1 : 1, gap = 2 * half * Math.sin((Math.PI / 2 - sign * s) / 2) ** 2;
        return rate_of(drop(sign > 0 ? high : low, -sign * gap));
      };
      pace = (s) => half * Math.abs(Math.cos(s)) / size(s);
      speed = (s) => Math.sign(Math.cos(s)) * size(s);
    }
    for (let k = 0; k <= COUNT; k += 1) {
      const s = start + k * TURN / COUNT;
      if (k) points.time.push(points.time[k - 1] + integral(pace, s - TURN / COUNT, s));
      points.theta.push(place(s));
      points.speed.push(speed(s));
    }
    return {...points, kind: turns ? "rotation" : "libration", period: points.time[COUNT]};
  };

  // Returns 50 s of a pendulum with damping rate xi, forced by A sin(Omega t), by Taylor series of order 20.
  const driven = (p) => {
    const ORDER = 20, LASTING = 50, STEPS = 2000, h = LASTING / STEPS, pull = p.gravity / p.length;
    const potential = (x) => -p.gravity * p.length * Math.cos(x);
    const energy = potential(p.theta) + (p.length * p.theta_dot) ** 2 / 2;
    const of = {time: [0], theta: [p.theta], speed: [p.theta_dot], potential, energy, barrier: p.gravity * p.length, period: 0};
    let [theta, speed] = [p.theta, p.theta_dot];
    for (let n = 0; n < STEPS; n += 1) {
      const a = [theta], w = [speed], s = [Math.sin(theta)], c = [Math.cos(theta)];
      for (let k = 0, size = p.forcing_amplitude; k < ORDER; k += 1) {
        const push = size * Math.sin(p.forcing_frequency * n * h + k * Math.PI / 2);
        a.push(w[k] / (k + 1));
        w.push((push - pull * s[k] - p.damping_rate * w[k]) / (k + 1));
        size *= p.forcing_frequency / (k + 1);
        let [sine, cosine] = [0, 0];
        for (let j = 1; j <= k + 1; j += 1) { sine += j * a[j] * c[k + 1 - j]; cosine -= j * a[j] * s[k + 1 - j]; }
        s.push(sine / (k + 1));
        c.push(cosine / (k + 1));
      }
      [theta, speed] = [a, w].map((series) => series.reduceRight((sum, value) => sum * h + value, 0));
      of.time.push((n + 1) * h);
      of.theta.push(theta);
      of.speed.push(speed);
    }
    const words = [...(p.damping_rate ? ["damped"] : []), ...(p.forcing_amplitude ? ["forced"] : [])].join(" and ");
    return {...of, kind: `${words}, θ ${text(theta, 6)} rad after ${LASTING} s`};
  };

  // ---- pictures ----
  const text = (value, digits = 4) => (Number.isFinite(value) ? String(Number(value.toPrecision(digits))) : "∞").replace("-", "−");
  const ticks = (low, high) => {
    const raw = (high - low) / 4, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((k) => k * power).find((size) => size >= raw), places = [];
    for (let k = Math.ceil(low / step); k * step <= high; k += 1) places.push(k * step);
    return places;
  };
  const ends = (values) => {
    const low = Math.min(...values), high = Math.max(...values), more = 0.05 * (high - low) || Math.abs(high) / 2 || 0.5;
    return [low - more, high + more];
  };
  // Draws curves given as [xs, ys, dashes]; points that are not finite are left out.
  const panel = (title, across, up, curves) => {
    const [x0, x1] = ends(curves.flatMap(([xs]) => xs)), [y0, y1] = ends(curves.flatMap(([, ys]) => ys));
    const x = (v) => (LEFT + (v - x0) / (x1 - x0) * (WIDE - LEFT - 10)).toFixed(1);
    const y = (v) => (LOW - (v - y0) / (y1 - y0) * (LOW - 10)).toFixed(1);
    const grid = [...ticks(x0, x1).map((v) => `M${x(v)} 10V${LOW}`), ...ticks(y0, y1).map((v) => `M${LEFT} ${y(v)}H${WIDE - 10}`)];
    const labels = [...ticks(x0, x1).map((v) => `<text class="m" x="${x(v)}" y="${LOW + 14}">${text(v)}</text>`),
      ...ticks(y0, y1).map((v) => `<text class="e" x="${LEFT - 4}" y="${Number(y(v)) + 4}">${text(v)}</text>`)];
    const lines = curves.map(([xs, ys, dashes = ""], k) =>
      `<path class="curve c${k}" stroke-dasharray="${dashes}" d="M${xs.map((v, i) => `${x(v)} ${y(ys[i])}`).join("L")}"/>`);
    return `<figure><figcaption>${title}</figcaption><svg viewBox="0 0 ${WIDE} ${HIGH}" role="img" aria-label="${title}: ${up} over ${across}">` +
      `<path class="g" d="${grid.join("")}"/><path class="a" d="M${LEFT} 10V${LOW}H${WIDE - 10}"/>${labels.join("")}${lines.join("")}` +
      `<text class="m" x="${(WIDE + LEFT) / 2}" y="${LOW + 31}">${across}</text><text class="m" x="11" y="86" transform="rotate(-90 11 86)">${up}</text></svg></figure>`;
  };
  const phases = (motion, unit = "J") => {
    const angles = Array.from({length: COUNT + 1}, (_, k) => -Math.PI + k * TURN / COUNT);
    const level = [[angles[0], angles[COUNT]], [motion.energy, motion.energy], "6 4"];
    const panels = [panel("V(θ), dashed: the energy", "θ [rad]", `V [${unit}]`, [[angles, angles.map(motion.potential)], level])];
    if (motion.theta.length) {
      panels.push(panel("phase curve", "θ [rad]", "dθ/dt [rad/s]", [[motion.theta, motion.speed]]),
        panel("θ(t), from the start", "t [s]", "θ [rad]", [[motion.time, motion.theta]]),
        panel("dθ/dt(t)", "t [s]", "dθ/dt [rad/s]", [[motion.time, motion.speed]]));
    }
    const period = motion.period > 0 && Number.isFinite(motion.period) ? ` of period ${text(motion.period, 6)} s` : "";
    return {panels, said: `${motion.kind}${period}: energy${motion.period ? "" : " at the start"} ${text(motion.energy)} ${unit}, barrier ${text(motion.barrier)} ${unit}`};
  };

  // ---- the systems: their parameters, their curves and the options of their commands ----
  const body = (p) => {
    const tan2 = Math.tan(p.apex_angle / 2) ** 2, mass = Math.PI / 3 * p.density * p.height ** 3 * tan2;
    const across = 0.15 * mass * p.height ** 2 * (4 + tan2), arm = 0.75 * p.height;
    return {mass, com_distance: arm, inertia_x: across, inertia_y: across, inertia_z: 0.3 * mass * p.height ** 2 * tan2};
  };
  const kinds = {
    cone: {
      defaults: (p) => ({...p, com_distance: body(p).com_distance}),
      changed: (p, first) => {
        if (p.com_distance === first.com_distance) return {};
        const of = body(p), more = of.mass * (p.com_distance ** 2 - of.com_distance ** 2);
        return {com_distance: p.com_distance, inertia_x: of.inertia_x + more, inertia_y: of.inertia_y + more};
      },
      shown: (p, changed) => {
        const of = {...body(p), ...changed}, rate2 = p.platform_rate ** 2;
        return swung({
          a: (of.inertia_y - of.inertia_z) * rate2 / 2, b: of.mass * of.com_distance * p.pivot_y * rate2,
          c: of.mass * of.com_distance * p.gravity, inertia: of.inertia_x, theta: p.theta, rate: p.theta_dot,
        });
      },
      drawn: phases,
    },
    pendulum: {
      defaults: (p) => p,
      changed: () => ({}),
      shown: (p) => p.damping_rate || p.forcing_amplitude ? driven(p) : swung({a: 0, b: 0, c: p.gravity * p.length, inertia: p.length ** 2, theta: p.theta, rate: p.theta_dot}),
      drawn: (motion) => phases(motion, "J/kg"),
    },
    turn: {
      defaults: (p, {scene, table}) => ({...p, epsilon: Number(scene.split("/")[1]), table: JSON.parse(table)}),
      changed: (p, first) => {
        const part = p.epsilon / first.epsilon;
        return part === 1 ? {} : {half_time: first.half_time * part, angular_acceleration: first.angular_acceleration / part ** 2};
      },
      shown: (p, changed) => {
        // (psi + 1)/epsilon^2 by cubics between the entries of a table, at equal steps of epsilon from 0 to 1.
        const at = (row, epsilon) => {
          const place = epsilon * (row.length - 1), first = Math.min(Math.max(Math.floor(place) - 1, 0), row.length - 4);
          let sum = 0;
          for (let j = 0; j < 4; j += 1) {
            let weight = row[first + j];
            for (let k = 0; k < 4; k += 1) if (k !== j) weight *= (place - first - k) / (j - k);
            sum += weight;
          }
          return epsilon ** 2 * sum - 1;
        };
        const epsilons = Array.from({length: COUNT + 1}, (_, k) => k / COUNT), half_time = changed.half_time || p.half_time;
        const [stop, rest] = p.table.map((row) => ({now: at(row, p.epsilon), exact: epsilons.map((e) => at(row, e)),
          next: row[0] * p.epsilon ** 2 - 1, nexts: epsilons.map((e) => row[0] * e ** 2 - 1)}));
        return {epsilon: p.epsilon, epsilons, half_time, stop, rest};
      },
      drawn: (m) => ({
        panels: [["at 2τ", m.stop], ["at rest", m.rest]].map(([when, of]) => panel(`ψ ${when}, dashed: the next term; eq. 32: −1`, "ε = τ/T", "ψ [rad]",
          [[m.epsilons, of.exact], [m.epsilons, of.nexts, "6 4"], [[m.epsilon, m.epsilon], [-1, Math.max(...of.nexts)], "2 3"]])),
        said: `at 2τ ψ is ${text(m.stop.now, 5)} rad, at rest ${text(m.rest.now, 5)} rad; eq. 32: −1, with its next term ` +
          `${text(m.stop.next, 5)} and ${text(m.rest.next, 5)}; τ ${text(1e3 * m.half_time)} ms`,
      }),
    },
    line: {
      defaults: (p) => p,
      changed: () => ({}),
      shown: (p) => {
        const mu = p.slider_mass / (p.slider_mass + p.body_mass), drag = p.friction * p.gravity, limit = drag / mu;
        if (p.w1 <= limit) return {refused: `the body stays: w₁ must be more than f g/μ = ${text(limit)} m/s²`};
        if (p.w2 > limit) return {refused: `the brake would move the body: w₂ may be f g/μ = ${text(limit)} m/s² at most`};
        const backward = mu * p.w1 - drag, braking = mu * p.w2 + drag, t1 = p.t1;
        const t_star = mu * (p.w1 + p.w2) * t1 / braking, t2 = (p.w1 + p.w2) * t1 / p.w2;
        const stroke = p.w1 * (p.w1 + p.w2) * t1 * t1 / (2 * p.w2), displacement = -backward * t1 * t_star / 2;
        const time = Array.from({length: COUNT + 1}, (_, k) => k * t2 / COUNT);
        const place = time.map((t) => (t < t1 ? -backward * t * t / 2 : t < t_star ? displacement + braking * (t_star - t) ** 2 / 2 : displacement));
        const speed = time.map((t) => (t < t1 ? -backward * t : -braking * Math.max(t_star - t, 0)));
        return {limit, displacement, t_star, t2, stroke, time, place, speed};
      },
      drawn: (m) => (m.refused ? {panels: [], said: m.refused} : {
        panels: [panel("displacement of C along the line", "t [s]", "displacement [m]", [[m.time, m.place]]),
          panel("velocity of C", "t [s]", "velocity [m/s]", [[m.time, m.speed]])],
        said: `Δx ${text(1e3 * m.displacement, 6)} mm, at rest at t* ${text(m.t_star, 6)} s, the slider at ${text(m.t2, 6)} s after ${text(1e3 * m.stroke)} mm; f g/μ = ${text(m.limit)} m/s²`,
      }),
    },
  };

  const begin = (root) => {
    for (const section of root.querySelectorAll(".sliders")) {
      const kind = kinds[section.dataset.kind], inputs = [...section.querySelectorAll("input")];
      const given = JSON.parse(section.dataset.parameters), first = kind.defaults(given, section.dataset);
      const touched = new Map();
      const draw = () => {
        const p = {...first};
        for (const input of inputs) {
          if (touched.has(input.name)) p[input.name] = touched.get(input.name);
          input.nextElementSibling.textContent = text(p[input.name]);
          input.setAttribute("aria-valuetext", text(p[input.name]));
        }
        const changed = kind.changed(p, first), {panels, said} = kind.drawn(section.answer = kind.shown(p, changed));
        section.querySelector("[role=status]").textContent = said[0].toUpperCase() + said.slice(1);
        section.querySelector(".panels").innerHTML = panels.join("");
        const set = Object.fromEntries([...touched].filter(([name]) => name in given || name === "theta_dot"));
        section.querySelector(".command code").textContent = [`plumbob solve ${section.dataset.scene}`,
          ...Object.entries({...set, ...changed}).map(([name, value]) => `--set ${name}=${value}`)].join(" ");
      };
      for (const input of inputs) {
        input.value = first[input.name];
        input.addEventListener("input", () => { touched.set(input.name, Number(input.value)); draw(); });
      }
      for (const button of section.querySelectorAll("[data-values]")) {
        button.addEventListener("click", () => {
          for (const [name, value] of Object.entries(JSON.parse(button.dataset.values))) {
            touched.set(name, value);
            section.querySelector(`[name=${name}]`).value = value;
          }
          draw();
        });
      }
      section.hidden = false;
      draw();
    }
  };
  document.addEventListener("plumbob:page", ({detail}) => begin(detail));
  begin(document);
})();
