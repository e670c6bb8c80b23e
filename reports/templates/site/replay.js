(() => {
  "use strict";
  // Replays: a canvas that draws a mechanism in its exact motion, and runs over it. The picture is a
  // function of the time, the magnification of errors and the layers that are on. Thumbnails draw the
  // exact motion alone.
  const reduced = matchMedia("(prefers-reduced-motion: reduce)");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const STILLS = 12;  // number of still pictures, one per second, for readers who prefer reduced motion
  const FONT = "12px system-ui, sans-serif";
  const TURN = 2 * Math.PI;
  const LIGHT = [0.2, 0.4, 0.6];  // brightness of a face that looks to the right, upwards and at the viewer
  const FEW = 12;  // most faces of a solid whose edges are drawn: a round one has more
  const ROUND = Array.from({length: 20}, (_, k) => [Math.cos(TURN * k / 20), Math.sin(TURN * k / 20)]);
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
    for (const [unit, size] of [["m", 1], ["cm", 0.01], ["mm", 1e-3], ["µm", 1e-6], ["nm", 1e-9]]) {
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

  // ---- states -------------------------------------------------------------------------------
  const layerOf = ({role, count, channels, times, error}, seconds) => ({
    role, on: true, channels: channels.map((given) => decoded(given, count)),
    times: times === undefined ? Float64Array.from({length: count}, (_, i) => i * seconds / (count - 1)) : decoded(times, count),
    error: error === undefined ? null : decoded(error, count),
  });
  // Values at a time, linear between the samples; the last ones after the end.
  const valuesAt = ({times}, channels, t) => {
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle; else high = middle;
    }
    const part = high > low ? Math.min(Math.max((t - times[low]) / (times[high] - times[low]), 0), 1) : 0;
    return channels.map((v) => v[low] + (v[high] - v[low]) * part);
  };

  // ---- vectors, and quaternions with the scalar first -------------------------------------------
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const plus = (a, b, times = 1) => a.map((value, i) => value + times * b[i]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((value) => value / (Math.hypot(...a) || 1));
  const product = ([a, ...u], [b, ...v]) => [a * b - dot(u, v), ...plus(plus(cross(u, v), v, a), u, b)];
  const rotated = ([w, ...u], p) => {
    const once = cross(u, p);
    return plus(plus(p, once, 2 * w), cross(u, once), 2);
  };

  // The frames of all bodies at coordinates: each joint of a body acts after the joints before it.
  const framesAt = (bodies, coordinates) => {
    const frames = [{place: [0, 0, 0], turn: [1, 0, 0, 0]}];
    let first = 0;
    const next = (count) => coordinates.slice(first, first += count);
    for (const {parent, place: offset, attitude, joints} of bodies) {
      let place = plus(frames[parent].place, rotated(frames[parent].turn, offset));
      let turn = product(frames[parent].turn, attitude);
      for (const {kind, axis, place: pivot, reference: [drawn]} of joints) {
        if (kind === "free") [place, turn] = [next(3), unit(next(4))];
        else if (kind === "slide") place = plus(place, rotated(turn, axis), next(1)[0] - drawn);
        else {
          const anchor = plus(place, rotated(turn, pivot));
          const half = kind === "hinge" ? (next(1)[0] - drawn) / 2 : 0;
          turn = product(turn, kind === "ball" ? unit(next(4)) : [Math.cos(half), ...axis.map((v) => v * Math.sin(half))]);
          place = plus(anchor, rotated(turn, pivot), -1);
        }
      }
      frames.push({place, turn});
    }
    return frames;
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

  // ---- the picture ----------------------------------------------------------------------------
  const WIDTHS = {first: 2, second: 1.3};
  const DASHES = {first: [9, 5], second: []};
  const RINGS = {first: [8.5, 2], second: [11.5, 1.5]};
  const picture = (canvas, data, highest) => {
    const pen = canvas.getContext("2d"), layers = data.layers.map((given) => layerOf(given, data.seconds));
    const [exact] = layers, [body, spot] = data.mark;
    let plan = null, ink = {};

    const stateAt = (layer, t, factor) => {
      const state = valuesAt(exact, exact.channels, t);
      return framesAt(data.bodies, layer === exact ? state : plus(state, valuesAt(layer, layer.channels, t), factor));
    };
    const errorAt = (layer, t) => valuesAt(layer, [layer.error], t)[0];
    const outside = (layer, t, factor) => layer !== exact && factor * errorAt(layer, t) > 4 * data.size;
    // To the right, upwards and towards the viewer.
    const viewed = (frames, body, p) => data.camera.map((axis) => dot(axis, plus(frames[body].place, rotated(frames[body].turn, p))));
    const place = ([x, y]) => [plan.x + plan.scale * x, plan.y - plan.scale * y];
    const marked = (frames) => place(viewed(frames, body, spot));

    const trace = (path, closed) => {
      pen.beginPath();
      for (const p of path) pen.lineTo(...p);
      if (closed) pen.closePath();
    };
    const stroke = (path, colour, {width = 1, dash = [], alpha = 1, closed = false} = {}) => {
      trace(path, closed);
      [pen.strokeStyle, pen.lineWidth, pen.globalAlpha] = [colour, width, alpha];
      pen.setLineDash(dash);
      pen.stroke();
      pen.globalAlpha = 1;
      pen.setLineDash([]);
    };
    const fill = (path, colour) => {
      trace(path, true);
      pen.fillStyle = colour;
      pen.fill();
    };
    const shaded = (colour, light) => `rgb(${colour.map((value) => Math.round(value * (0.5 + 0.55 * light)))})`;
    const outline = ({radius}, seen) => {
      const flat = seen.map(place), wide = (radius || 0) * plan.scale;
      return hull(wide ? flat.flatMap(([x, y]) => ROUND.map(([c, s]) => [x + wide * c, y + wide * s])) : flat);
    };
    const drawSolid = (frames, solid, seen) => {
      const {faces, colour, body, points, radius} = solid;
      if (solid.floor) {
        fill(seen.map(place), ink.disc);
        stroke(seen.map(place), ink.quiet, {width: 0.7, closed: true});
        return;
      }
      const edge = outline(solid, seen);
      fill(edge, shaded(colour, 0.8));
      for (const face of faces || []) {
        const corners = face.map((k) => seen[k]), sides = [1, 2].map((k) => plus(corners[k], corners[0], -1));
        const normal = unit(cross(...sides));
        if (normal[2] <= 0) continue;
        fill(corners.map(place), shaded(colour, Math.max(dot(LIGHT, normal), 0.1)));
        if (faces.length <= FEW) stroke(corners.map(place), shaded(colour, 0.3), {width: 0.5, alpha: 0.5, closed: true});
      }
      // A radius shows how a ball turns.
      if (radius && points.length === 1) {
        const rim = viewed(frames, body, plus(points[0], [radius, 0, 0]));
        if (rim[2] >= seen[0][2] - 0.01 * radius) stroke([place(seen[0]), place(rim)], shaded(colour, 0), {width: 1.5});
      }
      if (body) stroke(edge, ink.exact, {alpha: 0.6, closed: true});
    };
    const shapes = (frames, solids) => solids.map((solid) => {
      const seen = solid.points.map((p) => viewed(frames, solid.body, p));
      return {solid, seen, depth: solid.floor ? -Infinity : seen.reduce((sum, p) => sum + p[2], 0) / seen.length};
    }).sort((a, b) => a.depth - b.depth);
    const mark = (role, [x, y]) => {
      const [radius, width] = RINGS[role] || [5.5, 0];
      pen.beginPath();
      pen.arc(x, y, radius, 0, TURN);
      [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = [ink.exact, ink[role], width];
      if (width) pen.stroke(); else pen.fill();
    };
    const ruler = () => {
      const most = 0.3 * plan.width / plan.scale, size = rounded(most);
      const length = (size > most ? size / 2 : size), y = plan.height - 14;
      const end = 14 + length * plan.scale;
      stroke([[14, y - 4], [14, y], [end, y], [end, y - 4]], ink.quiet);
      [pen.fillStyle, pen.textBaseline] = [ink.quiet, "middle"];
      pen.fillText(metres(length), end + 6, y - 2);
    };
    const trail = (t) => Array.from({length: 61}, (_, k) =>
      marked(stateAt(exact, Math.max(t - data.trail, 0) + k / 60 * Math.min(t, data.trail), 0)));

    const draw = (t, factor = 1, bare = false) => {
      if (!plan) return;
      pen.clearRect(0, 0, plan.width, plan.height);
      const shown = layers.filter((layer) => layer.on && !outside(layer, t, factor))
        .map((layer) => [layer.role, stateAt(layer, t, factor)]);
      const truth = stateAt(exact, t, 0), moving = data.solids.filter((solid) => solid.body);
      const filled = exact.on ? data.solids : data.solids.filter((solid) => !solid.body);
      for (const {solid, seen} of shapes(truth, filled)) drawSolid(truth, solid, seen);
      stroke(trail(t), ink.exact, {width: 1.5, alpha: 0.5});
      for (const [role, frames] of shown) {
        if (role === "exact") continue;
        for (const {solid, seen} of shapes(frames, moving)) {
          stroke(outline(solid, seen), ink[role], {width: WIDTHS[role], dash: DASHES[role], closed: true});
        }
      }
      if (bare) return;
      for (const [role, frames] of shown) mark(role, marked(frames));
      ruler();
    };
    const fit = () => {
      if (!canvas.clientWidth) return;
      const style = getComputedStyle(canvas), ratio = devicePixelRatio || 1;
      for (const name of ["exact", "first", "second", "disc", "quiet"]) ink[name] = style.getPropertyValue(`--${name}`).trim();
      const width = canvas.clientWidth, [left, right, bottom, top] = data.box;
      const height = Math.min(width * (top - bottom) / (right - left), highest);
      const scale = Math.min(width / (right - left), height / (top - bottom));
      plan = {width, height, scale, x: width / 2 - scale * (left + right) / 2, y: height / 2 + scale * (top + bottom) / 2};
      canvas.style.height = `${height}px`;
      [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      [pen.font, pen.lineJoin] = [FONT, "round"];
      canvas.dataset.plan = JSON.stringify(plan);
    };
    const watched = (redraw) => {
      const refit = () => { fit(); redraw(); };
      refit();
      new ResizeObserver(() => { if (!plan || canvas.clientWidth !== plan.width) refit(); }).observe(canvas);
      dark.addEventListener("change", refit);
    };
    return {layers, draw, errorAt, outside, watched};
  };

  const replay = (figure, data) => {
    const canvas = figure.querySelector("canvas");
    const range = figure.querySelector("input[type=range]"), now = figure.querySelector(".now");
    const button = figure.querySelector(".play"), said = figure.querySelector(".said");
    const speed = figure.querySelector(".speed"), factor = figure.querySelector(".factor");
    const errors = [...figure.querySelectorAll(".layers li")];
    const {layers, draw: drawAt, errorAt, outside, watched} = picture(canvas, data, 440);
    const last = Number(range.max);
    let t = 0;
    const draw = () => drawAt(t, Number(factor.value));

    // ---- controls ---------------------------------------------------------------------------
    const report = () => {
      now.textContent = `${clock(t)} of ${clock(data.seconds)}`;
      layers.forEach((layer, k) => {
        const shown = errors[k] && errors[k].querySelector(".error");
        if (shown) shown.textContent = `, now ${metres(errorAt(layer, t))}${outside(layer, t, Number(factor.value)) ? ": outside the picture" : ""}`;
      });
    };
    // A screen reader announces a state after a click or a key, but never while the replay plays.
    let spoken = 0, reported = 0;
    const say = (word) => {
      clearTimeout(spoken);
      const found = layers.filter((layer) => layer.error && layer.on)
        .map((layer) => `${errors[layers.indexOf(layer)].querySelector("label").textContent.trim()}: error ${metres(errorAt(layer, t))}`);
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

    figure.querySelector(".live").hidden = false;
    watched(draw);
    report();

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

  // Thumbnails are still until a pointer or the focus is on their card, then they move over and over.
  const STILL = 0.4, LASTING = 4000;  // fraction of the motion in the still picture; [ms] of a moving one
  const thumbnail = (canvas, data) => {
    const {draw, watched} = picture(canvas, data, 96), card = canvas.closest("li");
    const still = () => draw(STILL * data.seconds, 1, true);
    let begin = 0;
    const step = (stamp) => {
      if (!begin) return still();
      draw(data.seconds * ((STILL + Math.max(stamp - begin, 0) / LASTING) % 1), 1, true);
      requestAnimationFrame(step);
    };
    const move = () => {
      if (reduced.matches || begin) return;
      begin = performance.now();
      requestAnimationFrame(step);
    };
    for (const kind of ["pointerenter", "focusin"]) card.addEventListener(kind, move);
    for (const kind of ["pointerleave", "focusout"]) card.addEventListener(kind, () => { begin = 0; });
    watched(still);
  };

  const near = new IntersectionObserver((entries) => {
    for (const {isIntersecting, target} of entries) {
      if (!isIntersecting) continue;
      near.unobserve(target);
      plumbob.once(target.querySelector("script"), JSON.parse).then((data) => {
        if (target.matches(".replay")) replay(target, data);
        else for (const canvas of target.querySelectorAll("canvas")) thumbnail(canvas, data[canvas.dataset.system]);
      });
    }
  }, {rootMargin: "300px"});
  const begin = (root) => { for (const figure of root.querySelectorAll(".replay, .systems:has(canvas)")) near.observe(figure); };
  document.addEventListener("plumbob:page", ({detail}) => begin(detail));
  begin(document);
})();
