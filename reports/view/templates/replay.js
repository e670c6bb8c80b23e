(() => {
  "use strict";
  // Replays: a canvas that draws the exact motion and runs over it. The picture is a function of the
  // time, the magnification of errors and the layers that are on.
  const reduced = matchMedia("(prefers-reduced-motion: reduce)");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const STILLS = 12;  // number of still pictures, one per second, for readers who prefer reduced motion
  const FONT = "12px system-ui, sans-serif";
  const TURN = 2 * Math.PI;
  const SUBSCRIPTS = ["₁", "₂", "₃"];
  const ATTITUDE = ["w", "x", "y", "z"].map((axis) => `attitude_${axis}`);
  let playing = null;  // the only replay that plays

  // Restores values from third differences of whole numbers of steps.
  const decoded = (given, count) => {
    if (typeof given === "number") return new Float64Array(count).fill(given);
    let [first, second, steps] = [0, 0, 0];
    return Float64Array.from(given.differences, (third) => given.low + given.step * (steps += first += second += third));
  };

  const number = (value, digits = 3) => {
    if (!value) return "0";
    const size = Math.abs(value);
    if (size >= 1e-3 && size < 1e5) return String(Number(value.toPrecision(digits)));
    return value.toExponential(digits - 1).replace("e+", "e");
  };
  const metres = (value) => {
    for (const [unit, size] of [["m", 1], ["mm", 1e-3], ["µm", 1e-6], ["nm", 1e-9]]) {
      if (Math.abs(value) >= size) return `${number(value / size)} ${unit}`;
    }
    return `${number(value)} m`;
  };
  const clock = (value) => {
    for (const [unit, size] of [["s", 1], ["ms", 1e-3], ["µs", 1e-6]]) {
      if (value >= size) return `${number(value / size)} ${unit}`;
    }
    return "0 s";
  };
  const rounded = (raw) => {
    const power = 10 ** Math.floor(Math.log10(raw));
    return [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
  };
  const turned = (angle) => angle - TURN * Math.round(angle / TURN);

  const layerOf = (given, data) => {
    const count = given.count, channels = {};
    for (const name of Object.keys(given.channels)) channels[name] = decoded(given.channels[name], count);
    const absolute = given.times === undefined;
    const times = absolute ? Float64Array.from({length: count}, (_, i) => i * data.seconds / (count - 1))
      : decoded(given.times, count);
    return {role: given.role, count, channels, absolute, times, on: true};
  };
  const before = (times, t) => {
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle; else high = middle;
    }
    return low;
  };
  const valueAt = (layer, name, t) => {
    const v = layer.channels[name], x = layer.times, n = layer.count;
    if (!v) return 0;
    if (t <= x[0]) return v[0];
    if (t >= x[n - 1]) return v[n - 1];
    const i = before(x, t);
    return v[i] + (v[i + 1] - v[i]) * (t - x[i]) / (x[i + 1] - x[i]);
  };

  const hull = (places) => {
    const sorted = [...places].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const half = (list) => {
      const kept = [];
      for (const p of list) {
        while (kept.length > 1) {
          const [a, b] = kept.slice(-2);
          if ((b[0] - a[0]) * (p[1] - a[1]) > (b[1] - a[1]) * (p[0] - a[0])) break;
          kept.pop();
        }
        kept.push(p);
      }
      return kept.slice(0, -1);
    };
    return [...half(sorted), ...half(sorted.reverse())];
  };

  const replay = (figure, data) => {
    const canvas = figure.querySelector("canvas"), front = canvas.getContext("2d");
    const range = figure.querySelector("input[type=range]"), now = figure.querySelector(".now");
    const button = figure.querySelector(".play"), said = figure.querySelector(".said");
    const speed = figure.querySelector(".speed"), factor = figure.querySelector(".factor");
    const errors = [...figure.querySelectorAll(".layers li")];
    const layers = data.layers.map((given) => layerOf(given, data));
    const exact = layers[0], shape = data.geometry;
    const last = Number(range.max);
    const enlarged = () => Number(factor.value);
    let t = 0, plan = null, ink = {}, pen = front;

    // ---- states -----------------------------------------------------------------------------
    const derived = (state) => {
      if (data.kind === "pendulum") {
        state.x = shape.length * Math.sin(state.theta);
        state.y = -shape.length * Math.cos(state.theta);
      } else if (data.kind === "body") {
        const size = Math.hypot(...ATTITUDE.map((name) => state[name]));
        for (const name of ATTITUDE) state[name] /= size;
      }
      return state;
    };
    const stateAt = (layer, at) => {
      const from = layer.absolute ? layer : exact, state = {t: at};
      for (const name of Object.keys(from.channels)) state[name] = valueAt(from, name, at);
      if (!layer.absolute) {
        const times = enlarged();
        for (const name of Object.keys(layer.channels)) {
          state[name] += times * valueAt(layer, name, at);
        }
      }
      return derived(state);
    };
    const apart = (layer, at) => {
      const of = (name) => valueAt(layer, name, at);
      if (data.kind === "geoms") {
        return {size: Math.max(...shape.bodies.map((k) => Math.hypot(...["x", "y", "z"].map((axis) => of(k + axis))))), turn: 0};
      }
      if (data.kind === "capsule") return {size: Math.hypot(of("x"), of("y")), turn: of("heading")};
      if (data.kind === "body") return {size: 0, turn: 2 * Math.hypot(...ATTITUDE.map(of))};
      return {size: 0, turn: of("theta")};
    };
    const outside = (layer, at) => {
      if (layer.absolute) return false;
      const times = enlarged(), {size, turn} = apart(layer, at);
      if (data.kind === "capsule" || data.kind === "geoms") {
        return times * size > 4 * data.size || (times > 1 && times * Math.abs(turn) > Math.PI);
      }
      return times > 1 && times * Math.abs(turn) > Math.PI;
    };

    // ---- positions --------------------------------------------------------------------------
    const laidOut = () => {
      const width = canvas.clientWidth, [left, right, bottom, top] = data.box;
      const height = Math.min(width * (top - bottom) / (right - left), 440);
      const scale = Math.min(width / (right - left), height / (top - bottom));
      return {
        width, height,
        picture: {
          width, height, scale,
          x: width / 2 - scale * (left + right) / 2, y: height / 2 + scale * (top + bottom) / 2,
        },
      };
    };
    const place = (x, y) => [plan.picture.x + plan.picture.scale * x, plan.picture.y - plan.picture.scale * y];

    // ---- drawing ----------------------------------------------------------------------------
    const WIDTHS = {exact: 5, first: 2, second: 1.3};
    const DASHES = {exact: [], first: [9, 5], second: []};
    const RINGS = {first: [8.5, 2], second: [11.5, 1.5]};
    const stroke = (role, path, closed = false) => {
      pen.beginPath();
      path.forEach((p, i) => {
        if (p && i && path[i - 1]) pen.lineTo(...p);
        else if (p) pen.moveTo(...p);
      });
      if (closed) pen.closePath();
      pen.strokeStyle = ink[role];
      pen.globalAlpha = role === "exact" ? 0.4 : 1;
      pen.lineWidth = WIDTHS[role];
      pen.setLineDash(DASHES[role]);
      pen.stroke();
      pen.globalAlpha = 1;
      pen.setLineDash([]);
    };
    const thin = (path, colour, width = 1, dash = [], alpha = 1) => {
      pen.beginPath();
      path.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.setLineDash(dash);
      pen.globalAlpha = alpha;
      pen.stroke();
      pen.globalAlpha = 1;
      pen.setLineDash([]);
    };
    const mark = (role, [x, y]) => {
      pen.beginPath();
      if (role === "exact") {
        pen.arc(x, y, 5.5, 0, TURN);
        pen.fillStyle = ink.exact;
        pen.fill();
        return;
      }
      pen.arc(x, y, RINGS[role][0], 0, TURN);
      pen.strokeStyle = ink[role];
      pen.lineWidth = RINGS[role][1];
      pen.stroke();
    };
    const label = (text, [x, y], colour = ink.quiet, align = "center") => {
      pen.fillStyle = colour;
      pen.textAlign = align;
      pen.textBaseline = "middle";
      pen.fillText(text, x, y);
    };
    const arrow = (from, to, colour, width = 2) => {
      const angle = Math.atan2(to[1] - from[1], to[0] - from[0]), size = Math.hypot(to[0] - from[0], to[1] - from[1]);
      if (size < 2) return;
      const head = Math.min(9, size);
      const side = (turn) => [to[0] - head * Math.cos(angle + turn), to[1] - head * Math.sin(angle + turn)];
      thin([from, [to[0] - 0.7 * head * Math.cos(angle), to[1] - 0.7 * head * Math.sin(angle)]], colour, width);
      pen.beginPath();
      for (const [x, y] of [to, side(0.4), side(-0.4)]) pen.lineTo(x, y);
      pen.fillStyle = colour;
      pen.fill();
    };
    const ruler = () => {
      const most = 0.3 * plan.picture.width / plan.picture.scale, size = rounded(most);
      const length = (size > most ? size / 2 : size), y = plan.picture.height - 14;
      const end = 14 + length * plan.picture.scale;
      thin([[14, y - 4], [14, y], [end, y], [end, y - 4]], ink.quiet);
      label(metres(length), [end + 6, y - 2], ink.quiet, "left");
    };
    const trailOf = (seconds, where) => {
      const path = [];
      for (let k = 0; k <= 60; k += 1) {
        path.push(where(stateAt(exact, Math.max(t - seconds, 0) + k / 60 * Math.min(t, seconds))));
      }
      thin(path, ink.exact, 1.5, [], 0.5);
    };
    const angleArc = (middle, radius, from, to, at) => {
      const path = Array.from({length: 25}, (_, k) => at(from + (to - from) * k / 24, radius));
      thin(path, ink.quiet);
      const half = Math.abs(to - from) < 0.35 ? from - 0.3 * Math.sign(to - from || 1) : (from + to) / 2;
      label("θ", at(half, 1.25 * radius), ink.label);
    };

    const drawPendulum = (truth, shown) => {
      const pivot = place(0, 0), length = shape.length, theta = turned(truth.theta);
      trailOf(shape.trail, (s) => place(s.x, s.y));
      thin([pivot, place(0, -0.45 * length)], ink.quiet, 1, [3, 3]);
      angleArc(pivot, 0.32 * length, 0, theta, (a, r) => place(r * Math.sin(a), -r * Math.cos(a)));
      for (const {layer, state} of shown) stroke(layer.role, [pivot, place(state.x, state.y)]);
      pen.beginPath();
      pen.arc(...pivot, 4, 0, TURN);
      pen.fillStyle = ink.quiet;
      pen.fill();
      for (const {layer, state} of shown) mark(layer.role, place(state.x, state.y));
    };

    // The cone: positions in the platform's axes, turned with the platform, seen from infinity.
    const [across, upwards, towards] = shape.camera || [];
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const inWorld = ([x, y, z], at) => {
      const c = Math.cos(shape.rate * at), s = Math.sin(shape.rate * at);
      return [c * x - s * y, s * x + c * y, z];
    };
    const seen = (p, at) => {
      const world = inWorld(p, at);
      return place(dot(across, world), dot(upwards, world));
    };
    const depth = (p, at) => dot(towards, inWorld(p, at));
    const onCone = (theta, along, wide = 0, around = 0) => {
      const s = Math.sin(theta), c = Math.cos(theta), [x, y, z] = shape.pivot;
      const u = wide * Math.cos(around), v = wide * Math.sin(around);
      return [x + u, y + along * s + v * c, z - along * c + v * s];
    };
    const rim = (theta, corners) => Array.from({length: corners}, (_, k) =>
      onCone(theta, shape.height, shape.height * Math.tan(shape.half), TURN * k / corners));
    const drawSolid = (theta) => {
      const edge = rim(theta, 36), apex = onCone(theta, 0), middle = onCone(theta, shape.height);
      const lit = (a, b, c) => {
        const [p, q, r] = [a, b, c].map((one) => inWorld(one, t));
        const u = q.map((v, i) => v - p[i]), w = r.map((v, i) => v - p[i]);
        const n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
        const size = Math.hypot(...n) || 1, facing = dot(n, towards) / size;
        return {facing, light: (facing < 0 ? -1 : 1) * (0.5 * n[2] + 0.45 * dot(n, towards) + 0.3 * dot(n, across)) / size};
      };
      const faces = edge.map((p, k) => ({places: [apex, p, edge[(k + 1) % edge.length]]}));
      faces.push({places: [middle, edge[0], edge[12]], drawn: edge});
      for (const face of faces) {
        Object.assign(face, lit(...face.places));
        face.depth = face.drawn ? depth(middle, t) : (depth(face.places[1], t) + depth(face.places[2], t) + depth(apex, t)) / 3;
      }
      faces.sort((a, b) => a.depth - b.depth);
      for (const face of faces) {
        pen.beginPath();
        for (const p of face.drawn || face.places) pen.lineTo(...seen(p, t));
        pen.closePath();
        pen.fillStyle = `hsl(${ink.solid} ${Math.round(46 + 26 * face.light)}%)`;
        pen.fill();
        pen.strokeStyle = pen.fillStyle;
        pen.lineWidth = 0.7;
        pen.stroke();
      }
    };
    const drawCone = (truth, shown) => {
      const ring = (radius, from = 0, to = TURN, turning = t) => Array.from({length: 61}, (_, k) => {
        const a = from + (to - from) * k / 60;
        return seen([radius * Math.cos(a), radius * Math.sin(a), shape.floor], turning);
      });
      pen.beginPath();
      for (const p of ring(shape.radius)) pen.lineTo(...p);
      pen.fillStyle = ink.disc;
      pen.fill();
      for (let k = 0; k < 6; k += 1) {
        const a = TURN * k / 6, r = shape.radius;
        thin([seen([0, 0, shape.floor], t), seen([r * Math.cos(a), r * Math.sin(a), shape.floor], t)], ink.rule);
      }
      if (shape.rate) {
        const sign = Math.sign(shape.rate), path = ring(1.1 * shape.radius, -1.2, -1.2 + sign * 0.9, 0);
        thin(path, ink.quiet, 1.5);
        arrow(path[56], path[60], ink.quiet, 1.5);
        label("ω", seen([1.24 * shape.radius * Math.cos(-0.75), 1.24 * shape.radius * Math.sin(-0.75), shape.floor], 0));
      }
      const [x, y, z] = shape.pivot, wide = 1.5 * shape.height * Math.tan(shape.half) + 0.05 * shape.height;
      const posts = [-wide, wide].map((dx) => [[x + dx, y, shape.floor], [x + dx, y, z]]);
      posts.sort((a, b) => depth(a[1], t) - depth(b[1], t));
      const post = ([foot, head]) => thin([seen(foot, t), seen(head, t)], ink.post, 4);
      post(posts[0]);
      thin([seen([x - wide, y, z], t), seen([x + wide, y, z], t)], ink.post, 3);
      if (exact.on) drawSolid(truth.theta);
      trailOf(shape.trail, (s) => seen(onCone(s.theta, shape.com), s.t));
      const theta = turned(truth.theta), at = (a, r) => seen(onCone(a, r), t);
      thin([at(0, 0), at(0, 0.6 * shape.height)], ink.quiet, 1, [3, 3]);
      angleArc(at(0, 0), 0.42 * shape.height, 0, theta, at);
      for (const {layer, state} of shown) {
        if (layer === exact) continue;
        stroke(layer.role, hull([onCone(state.theta, 0), ...rim(state.theta, 36)].map((p) => seen(p, t))), true);
      }
      post(posts[1]);
      for (const {layer, state} of shown) mark(layer.role, at(state.theta, shape.com));
      const s = at(truth.theta, shape.com);
      label("S", [s[0] - 20, s[1] - 6], ink.label);
    };

    // The free body: positions in body axes, turned by the attitude.
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const rotated = ([w, ...u], p) => {
      const once = cross(u, p), twice = cross(u, once);
      return p.map((value, i) => value + 2 * (w * once[i] + twice[i]));
    };
    const turnedBy = (state, p) => rotated(ATTITUDE.map((name) => state[name]), p);
    const drawBody = (truth, shown) => {
      const on = (state, p) => seen(turnedBy(state, p), t), corner = shape.half;
      const sides = [0, 1, 2].flatMap((axis) => [-1, 1].map((sign) => [axis, sign]));
      const facing = (state) => sides.map(([axis, sign]) => {
        const n = turnedBy(state, [0, 1, 2].map((k) => (k === axis ? sign : 0)));
        const corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([a, b]) => {
          const p = [0, 0, 0];
          [p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]] = [sign, a, b];
          return p.map((value, k) => value * corner[k]);
        });
        return {n, corners, toward: dot(n, towards)};
      }).filter((side) => side.toward > 0);
      const [from, to] = [-1, 1].map((sign) => seen(shape.momentum.map((v) => sign * v), t));
      thin([from, to], ink.quiet, 1, [3, 3]);
      label("L", [to[0] + 10, to[1] - 4]);
      if (exact.on) {
        for (const {n, corners, toward} of facing(truth)) {
          pen.beginPath();
          for (const p of corners) pen.lineTo(...on(truth, p));
          pen.closePath();
          pen.fillStyle = `hsl(${ink.solid} ${Math.round(46 + 26 * (0.5 * n[2] + 0.45 * toward + 0.3 * dot(n, across)))}%)`;
          pen.fill();
        }
      }
      trailOf(shape.trail, (s) => on(s, corner));
      for (const {layer, state} of shown) {
        const edges = facing(state).flatMap(({corners}) => [...corners, corners[0]].map((p) => on(state, p)).concat([null]));
        stroke(layer.role, edges);
      }
      if (exact.on) {
        ["x", "y", "z"].forEach((name, k) => {
          const axis = [0, 1, 2].map((i) => (i === k ? 1 : 0));
          const [root, tip, text] = [corner[k], corner[k] + 0.18, corner[k] + 0.27].map((far) => on(truth, axis.map((v) => far * v)));
          thin([root, tip], ink.quiet, 1.5);
          label(name, text, ink.label);
        });
      }
      for (const {layer, state} of shown) mark(layer.role, on(state, corner));
      const p = on(truth, corner);
      label("P", [p[0] + 16, p[1] - 8], ink.label);
    };

    // An audited model: each geom is the hull of its points, thickened by a radius; far geoms first.
    const AXES = ["x", "y", "z", "qw", "qx", "qy", "qz"];
    const placed = ({body, points}, state) => {
      if (!body) return points;
      const [x, y, z, ...q] = AXES.map((axis) => state[body + axis]), size = Math.hypot(...q);
      return points.map((p) => rotated(q.map((v) => v / size), p)).map((p) => [p[0] + x, p[1] + y, p[2] + z]);
    };
    const drawSolids = (solids, state, edge, fill) => {
      const far = solids.map((solid) => {
        const places = placed(solid, state);
        return {solid, places, depth: places.reduce((sum, p) => sum + dot(towards, p), 0) / places.length};
      }).sort((a, b) => a.depth - b.depth);
      pen.lineCap = "round";
      for (const {solid, places} of far) {
        const flat = places.map((p) => seen(p, t)), path = flat.length > 2 ? hull(flat) : flat;
        const wide = 2 * solid.radius * plan.picture.scale;
        pen.beginPath();
        for (const [x, y] of path) { pen.lineTo(x, y); pen.lineTo(x + 0.01, y); }
        pen.closePath();
        for (const [colour, more] of [[edge, 1.6], [fill(solid), 0]]) {
          pen.strokeStyle = pen.fillStyle = colour;
          pen.lineWidth = wide + more;
          if (pen.lineWidth && (more || wide)) pen.stroke();
          if (path.length > 2) pen.fill();
        }
      }
      pen.lineCap = "butt";
    };
    const veil = document.createElement("canvas");
    const drawGeoms = (truth, shown) => {
      const grey = ({body}) => `hsl(210 8% ${56 + 9 * (body % 3)}%)`;
      drawSolids(shape.solids.filter((one) => !one.body), truth, ink.rule, () => ink.disc);
      const moving = shape.solids.filter((one) => one.body);
      const spotOf = (state) => seen(["x", "y", "z"].map((axis) => state[shape.worst + axis]), t);
      if (exact.on) drawSolids(moving, truth, ink.exact, grey);
      trailOf(shape.trail, spotOf);
      for (const {layer, state} of shown.filter((one) => one.layer !== exact)) {
        const ratio = devicePixelRatio || 1;
        [veil.width, veil.height] = [canvas.width, canvas.height];
        pen = veil.getContext("2d");
        pen.scale(ratio, ratio);
        pen.lineJoin = "round";
        drawSolids(moving, state, ink.label, () => ink[layer.role]);
        pen = front;
        pen.globalAlpha = 0.45;
        pen.drawImage(veil, 0, 0, plan.width, plan.height);
        pen.globalAlpha = 1;
      }
      for (const {layer, state} of shown) mark(layer.role, spotOf(state));
    };

    const slid = () => {
      const {qx, qy} = exact.channels, path = [[qx[0], qy[0]]];
      for (let i = 1; i < exact.count; i += 1) {
        const [x, y] = path[path.length - 1];
        if (Math.hypot(qx[i] - x, qy[i] - y) > 0.01 * shape.size) path.push([qx[i], qy[i]]);
      }
      return path;
    };
    const track = data.kind === "capsule" ? slid() : [];
    const drawCapsule = (state, shown) => {
      const body = (state, [px, py]) => {
        const c = Math.cos(state.heading), s = Math.sin(state.heading);
        return [state.x + c * px - s * py, state.y + s * px + c * py];
      };
      const at = (p) => place(...body(state, p));
      const triangle = shape.feet.map(at);
      if (exact.on) {
        pen.beginPath();
        for (const p of triangle) pen.lineTo(...p);
        pen.closePath();
        pen.fillStyle = ink.disc;
        pen.fill();
        thin(track.map(at), ink.quiet, 1, [2, 3]);
      }
      trailOf(data.seconds, (s) => place(s.x, s.y));
      for (const {layer, state: own} of shown) {
        stroke(layer.role, shape.feet.map((p) => place(...body(own, p))), true);
      }
      if (exact.on) {
        shape.feet.forEach((foot, k) => {
          const [x, y] = body(state, foot);
          pen.beginPath();
          pen.arc(...place(x, y), 4, 0, TURN);
          pen.strokeStyle = ink.quiet;
          pen.fillStyle = ink.tint;
          pen.fill();
          pen.lineWidth = 1.5;
          pen.stroke();
          const far = Math.hypot(x - state.x, y - state.y) || 1, out = 1 + 18 / plan.picture.scale / far;
          label(`A${SUBSCRIPTS[k]}`, place(state.x + out * (x - state.x), state.y + out * (y - state.y)), ink.label);
        });
        const [qx, qy] = at([state.qx, state.qy]);
        pen.fillStyle = ink.drive;
        pen.fillRect(qx - 6.5, qy - 6.5, 13, 13);
        label("Q", [qx + 16, qy + 13], ink.drive);
      }
      for (const {layer, state: own} of shown) mark(layer.role, place(own.x, own.y));
      const c = place(state.x, state.y);
      label("C", [c[0] - 18, c[1] + 14], ink.label);
    };

    const DRAW = {pendulum: drawPendulum, cone: drawCone, capsule: drawCapsule, body: drawBody, geoms: drawGeoms};
    const draw = () => {
      if (!plan) return;
      pen.clearRect(0, 0, plan.width, plan.height);
      const truth = stateAt(exact, t);
      const shown = layers.filter((layer) => layer.on && !outside(layer, t))
        .map((layer) => ({layer, state: layer === exact ? truth : stateAt(layer, t)}));
      pen.save();
      pen.beginPath();
      pen.rect(0, 0, plan.picture.width, plan.picture.height);
      pen.clip();
      DRAW[data.kind](truth, shown);
      if (data.kind !== "body") ruler();
      pen.restore();
    };

    // ---- controls ---------------------------------------------------------------------------
    const apartText = (layer) => {
      const {size, turn} = apart(layer, t);
      if (data.kind === "capsule" || data.kind === "geoms") return metres(size) + (Math.abs(turn) > 1e-9 ? `, ${number(Math.abs(turn))} rad` : "");
      return `${number(Math.abs(turn))} rad`;
    };
    const report = () => {
      now.textContent = `${clock(t)} of ${clock(data.seconds)}`;
      layers.forEach((layer, k) => {
        const shown = errors[k] && errors[k].querySelector(".error");
        if (shown) shown.textContent = `, now ${apartText(layer)}${outside(layer, t) ? ": outside the picture" : ""}`;
      });
    };
    // A screen reader announces a state after a click or a key, but never while the replay plays.
    let spoken = 0, reported = 0;
    const say = (word) => {
      clearTimeout(spoken);
      const found = layers.filter((layer) => !layer.absolute && layer.on)
        .map((layer) => `${errors[layers.indexOf(layer)].querySelector("label").textContent.trim()}: error ${apartText(layer)}`);
      said.textContent = [`${word} at ${clock(t)} of ${clock(data.seconds)}`, ...found].join("; ");
    };
    const seek = (time, quiet = false) => {
      t = Math.min(Math.max(time, 0), data.seconds);
      range.value = Math.round(last * t / data.seconds);
      draw();
      const late = performance.now();
      if (quiet && late - reported < 200 && t < data.seconds) return;
      reported = late;
      range.setAttribute("aria-valuetext", `${clock(t)} of ${clock(data.seconds)}`);
      report();
      if (quiet) return;
      clearTimeout(spoken);
      spoken = setTimeout(() => say("Shown"), 700);
    };
    let stamped = 0;
    const stop = (word = "Paused") => {
      if (playing === stop) playing = null;
      button.textContent = "Play";
      report();
      if (word) say(word);
    };
    const step = (stamp) => {
      if (playing !== stop) return;
      const pace = reduced.matches ? data.seconds / STILLS : data.seconds / speed.value;
      const passed = reduced.matches ? Math.floor((stamp - stamped) / 1000) : (stamp - stamped) / 1000;
      if (passed > 0) {
        stamped = reduced.matches ? stamped + 1000 * passed : stamp;
        seek(t + pace * Math.min(passed, reduced.matches ? 1 : 0.1), true);
      }
      if (t >= data.seconds) stop("At the end,");
      else requestAnimationFrame(step);
    };
    const play = (word = "Playing") => {
      if (playing) playing("");
      if (t >= data.seconds) t = 0;
      playing = stop;
      stamped = performance.now();
      button.textContent = "Pause";
      if (word) say(word);
      requestAnimationFrame(step);
    };
    const toggle = () => { if (playing === stop) stop(); else play(); };
    const halted = () => { if (playing === stop) stop(""); };

    button.addEventListener("click", toggle);
    canvas.addEventListener("click", toggle);
    range.addEventListener("input", () => { halted(); seek(data.seconds * range.value / last); });
    const KEYS = {
      ArrowRight: 0.01, ArrowUp: 0.01, ArrowLeft: -0.01, ArrowDown: -0.01, PageUp: 0.1, PageDown: -0.1,
      Home: -1, End: 1,
    };
    figure.querySelector(".controls").addEventListener("keydown", (event) => {
      const {key, target} = event;
      if (event.ctrlKey || event.altKey || event.metaKey || target.tagName === "SELECT") return;
      if (key === " " && target !== button) toggle();
      else if (key in KEYS) { halted(); seek(t + KEYS[key] * data.seconds); }
      else return;
      event.preventDefault();
    });
    factor.addEventListener("change", () => { draw(); report(); });
    layers.forEach((layer, k) => {
      const box = errors[k].querySelector("input");
      box.hidden = false;
      box.addEventListener("change", () => { layer.on = box.checked; draw(); });
    });

    const dip = () => {
      const style = getComputedStyle(figure);
      ink = {post: "#8c96a1"};
      for (const name of ["exact", "label", "first", "second", "drive", "solid", "disc", "quiet", "rule", "grid", "tint"]) {
        ink[name] = style.getPropertyValue(`--${name}`).trim();
      }
    };
    const fit = () => {
      if (!canvas.clientWidth) return;
      const ratio = devicePixelRatio || 1;
      dip();
      plan = laidOut();
      canvas.style.height = `${plan.height}px`;
      canvas.width = Math.round(plan.width * ratio);
      canvas.height = Math.round(plan.height * ratio);
      front.setTransform(ratio, 0, 0, ratio, 0, 0);
      [front.font, front.lineJoin] = [FONT, "round"];
      canvas.dataset.plan = JSON.stringify(plan);
      draw();
    };
    figure.classList.add("moving");
    figure.querySelector(".live").hidden = false;
    fit();
    report();
    new ResizeObserver(() => { if (!plan || canvas.clientWidth !== plan.width) fit(); }).observe(canvas);
    dark.addEventListener("change", fit);

    // The replay starts by itself, once, when all of it is visible, unless the reader prefers reduced motion.
    let begun = reduced.matches;
    const touched = () => { begun = true; };
    for (const kind of ["pointerdown", "keydown", "focusin"]) figure.addEventListener(kind, touched);
    new IntersectionObserver((entries) => {
      const entry = entries[entries.length - 1];
      if (!entry.isIntersecting) halted();
      else if (entry.intersectionRatio > 0.9 && !begun && !playing) { begun = true; play(""); }
    }, {threshold: [0, 0.95]}).observe(canvas);
  };

  const near = new IntersectionObserver((entries) => {
    for (const {isIntersecting, target} of entries) {
      if (!isIntersecting) continue;
      near.unobserve(target);
      plumbob.once(target.querySelector("script"), JSON.parse).then((data) => replay(target, data));
    }
  }, {rootMargin: "300px"});
  const begin = (root) => { for (const figure of root.querySelectorAll(".replay")) near.observe(figure); };
  document.addEventListener("plumbob:page", ({detail}) => begin(detail));
  begin(document);
})();
