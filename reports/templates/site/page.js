(() => {
  "use strict";
  const page = document.getElementById("page");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // ---- plots: pictures that plotly draws anew under a mouse, after a press or a choice of methods ----
  const NEAR = "400px", FAR = "1200px", MOST = 8, ROWS = 12;
  let hidden = new Set(), drawn = new Set(), areas = [], chosen = false;

  // Returns the compressed text that the page holds, or that a script beside it holds.
  const text_of = (holder) => (!holder.dataset.src ? Promise.resolve(holder.textContent) : new Promise((done, failed) => {
    const script = Object.assign(document.createElement("script"), {src: holder.dataset.src});
    script.onload = () => done(script.textContent);
    script.onerror = () => failed(new Error(`${holder.dataset.src} is missing`));
    document.head.append(script);
  }));
  const unpacked = (text) => {
    const bytes = Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  };
  const run = (text) => new Promise((done) => {
    const src = URL.createObjectURL(new Blob([text], {type: "text/javascript"}));
    document.head.append(Object.assign(document.createElement("script"), {src, onload: done}));
  });
  const loaded = new WeakMap();
  const once = (holder, use) => {
    if (!loaded.has(holder)) loaded.set(holder, text_of(holder).then(unpacked).then(use));
    return loaded.get(holder);
  };
  window.plumbob = {once};
  const plotly = () => once(document.getElementById("plotly"), run);
  const held = () => once(page.querySelector(".figures"), JSON.parse);

  const axis = (given) => ({
    gridcolor: colour("--grid"), linecolor: colour("--rule"), zerolinecolor: colour("--rule"),
    automargin: Boolean(given.ticktext), ticks: "outside", tickcolor: colour("--rule"), ticklen: 4, showline: true,
    ...given, title: {standoff: 8, ...given.title, font: {size: 12}},
  });

  const themed = (layout) => {
    const full = {
      ...layout, autosize: true, hovermode: "closest", dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: {family: "system-ui, sans-serif", size: 12, color: colour("--ink")},
      margin: {l: 68, r: layout.yaxis2 ? 68 : 16, t: 8, b: 46, ...layout.margin},
      hoverlabel: {bgcolor: colour("--paper"), bordercolor: colour("--rule"),
        font: {size: 12, color: colour("--ink")}, align: "left"},
      legend: {orientation: "h", x: 0, y: 1.02, yanchor: "bottom", font: {size: 12}, ...layout.legend},
    };
    for (const key of Object.keys(layout)) {
      if (/^[xy]axis\d*$/.test(key)) full[key] = axis(layout[key]);
    }
    return full;
  };

  // Predictions are drawn in the ink of a light page; a dark page has its own.
  const INK = "#1d2329";
  const inked = (trace) => (trace.line?.color === INK ? {...trace, line: {...trace.line, color: colour("--ink")}} : trace);
  const shown = (trace) => !hidden.has(trace.meta);

  // Returns the Pareto front: the visible runs with a text that no other run beats in both speed and error.
  const front = (traces) => {
    const points = traces.filter((one) => one.text && one.visible)
      .flatMap((one) => one.x.map((x, i) => [x, one.y[i]]))
      .sort((a, b) => b[0] - a[0] || a[1] - b[1]);
    let best = Infinity;
    return points.filter(([, error]) => error < best && ((best = error), true));
  };

  const fronted = (traces) => traces.map((one) => {
    if (one.meta !== "front") return one;
    const points = front(traces);
    return {...one, x: points.map(([x]) => x), y: points.map(([, y]) => y)};
  });

  const read = async (area) => {
    const figure = (await held()).figures[area.dataset.figure];
    return {...figure, data: fronted(figure.data.map((trace) => ({...inked(trace), visible: shown(trace)})))};
  };

  // Returns the distance [px] from the middle of the window to the nearest part of a plot.
  const distance = (area) => {
    const at = area.getBoundingClientRect(), middle = innerHeight / 2;
    return Math.max(at.top - middle, middle - at.bottom, 0);
  };

  // Plotly finishes a change after its call returns: the next change of the plot waits for it.
  const queue = (area, wanted, change) => {
    const next = () => (drawn.has(area) === wanted ? change() : null);
    area.last = (area.last || Promise.resolve()).then(next, next);
  };

  const draw = async (area) => {
    if (drawn.has(area)) return;
    drawn.add(area);
    [...drawn].sort((a, b) => distance(a) - distance(b)).slice(MOST).forEach(remove);
    const [figure] = await Promise.all([read(area), plotly()]);
    queue(area, true, () => {
      const stage = document.createElement("div");
      stage.style.height = `${Math.max(area.offsetHeight, area.dataset.height)}px`;
      area.stage?.remove();
      area.stage = stage;
      area.given = figure.layout;
      area.append(stage);
      area.classList.add("drawn");
      return Plotly.newPlot(stage, figure.data, themed(figure.layout), {responsive: true, displayModeBar: false});
    });
  };

  const erase = (area) => {
    if (!area.stage) return;
    Plotly.purge(area.stage);
    area.stage.remove();
    area.stage = null;
    area.classList.remove("drawn");
  };

  const remove = (area) => {
    if (drawn.delete(area)) queue(area, false, () => erase(area));
  };

  const open = (area) => area.isConnected && !area.closest("details:not([open])");

  let near = null, far = null;
  const watch = (root) => {
    near?.disconnect();
    far?.disconnect();
    areas = [...root.querySelectorAll(".area")];
    if (!areas.length) return;
    near = new IntersectionObserver((entries) => {
      for (const {target, isIntersecting} of entries) {
        if (isIntersecting && chosen && open(target)) draw(target);
      }
    }, {rootMargin: NEAR});
    far = new IntersectionObserver((entries) => {
      for (const {target, isIntersecting} of entries) if (!isIntersecting) remove(target);
    }, {rootMargin: FAR});
    for (const area of areas) {
      near.observe(area);
      far.observe(area);
      area.querySelector("button").addEventListener("click", () => draw(area));
      area.addEventListener("pointerenter", (event) => { if (event.pointerType === "mouse") draw(area); });
    }
  };

  const restyle = () => {
    chosen = true;
    for (const area of drawn) {
      queue(area, true, async () => {
        const {data} = await read(area);
        return Plotly.react(area.stage, data, themed(area.given));
      });
    }
    areas.filter(inSight).forEach(draw);
  };

  // ---- the numbers of a plot as a table, while the table is open ----
  const text = (value) => (typeof value === "number" ? String(Number(value.toPrecision(4))) : String(value ?? "–"));
  const made = (tag, content, more = {}) => Object.assign(document.createElement(tag), {textContent: content}, more);
  const tabled = (area, figure) => {
    const titles = ["xaxis", "yaxis"].map((name) => figure.layout[name]?.title?.text || name[0]);
    const table = document.createElement("table"), head = table.createTHead().insertRow();
    table.createCaption().textContent = area.parentElement.querySelector("b").textContent;
    for (const title of ["curve", ...titles]) head.append(made("th", title, {scope: "col"}));
    const body = table.createTBody();
    for (const trace of figure.data.filter((one) => one.visible)) {
      const rows = trace.z ? trace.y.map((y, i) => [y, trace.z[i].map(text).join(" ")]) : trace.x.map((x, i) => [x, trace.y[i]]);
      const every = Math.max(1, Math.ceil(rows.length / ROWS));
      rows.filter((_, i) => i % every === 0).forEach(([x, y], i) => {
        const line = body.insertRow();
        line.append(made("th", i ? "" : trace.name || "curve", {scope: "row"}));
        if (i) line.firstChild.replaceWith(document.createElement("td"));
        line.append(made("td", text(x), {className: "number"}), made("td", text(y), {className: "number"}));
      });
    }
    const around = made("div", "", {className: "scroll"});
    around.append(table);
    return around;
  };

  // ---- the hint of a cell: shown beside the cell on hover, focus and tap ----
  const tip = Object.assign(made("div", ""), {id: "tip", hidden: true});
  tip.setAttribute("role", "tooltip");
  document.body.append(tip);
  const show = (button) => {
    tip.textContent = button.dataset.hint;
    tip.hidden = false;
    button.setAttribute("aria-describedby", "tip");
    const at = button.getBoundingClientRect(), size = tip.getBoundingClientRect();
    const above = at.bottom + size.height + 8 > innerHeight && at.top > size.height + 8;
    tip.style.left = `${Math.max(8, Math.min(at.left, document.documentElement.clientWidth - size.width - 8)) + scrollX}px`;
    tip.style.top = `${(above ? at.top - size.height - 4 : at.bottom + 4) + scrollY}px`;
  };
  const hide = () => { tip.hidden = true; };
  for (const kind of ["click", "focusin", "mouseover"]) {
    document.addEventListener(kind, (event) => {
      const button = event.target.closest?.(".hint");
      if (button) show(button);
      else if (kind !== "focusin" && !event.target.closest?.("#tip")) hide();
    });
  }
  document.addEventListener("focusout", hide);
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") hide();
    const button = event.target.closest?.(".hint");
    if (!button || !/^Arrow/.test(event.key)) return;
    // The tab key stops once in a table; arrows move within it.
    const cell = button.closest("td, th"), line = cell.parentElement;
    const lines = [...line.parentElement.rows], column = cell.cellIndex;
    const sideways = [...line.querySelectorAll(".hint")], row = lines.indexOf(line);
    const upright = lines.map((one) => one.cells[column]?.querySelector(".hint"));
    const next = {
      ArrowRight: () => sideways[sideways.indexOf(button) + 1],
      ArrowLeft: () => sideways[sideways.indexOf(button) - 1],
      ArrowDown: () => upright.slice(row + 1).find(Boolean),
      ArrowUp: () => upright.slice(0, row).reverse().find(Boolean),
    }[event.key]();
    event.preventDefault();
    if (!next) return;
    button.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });

  // ---- a wide table or a long line of code scrolls inside its box, and a screen reader announces it ----
  const sized = new ResizeObserver((entries) => entries.forEach(({target}) => overflow(target)));
  const overflow = (box) => {
    const wide = box.scrollWidth > box.clientWidth + 1;
    box.classList.toggle("more", wide && box.scrollLeft + box.clientWidth < box.scrollWidth - 1);
    if (box.matches("pre")) return;  // code can be focused without further attributes
    if (!wide && box.scrollHeight <= box.clientHeight + 1) { box.removeAttribute("tabindex"); box.removeAttribute("role"); box.removeAttribute("aria-label"); return; }
    box.tabIndex = 0;
    box.setAttribute("role", "group");
    box.setAttribute("aria-label", `${box.querySelector("caption")?.textContent || "table"}, scrolls`);
  };
  const scrolls = (root) => {
    for (const box of root.querySelectorAll(".scroll, pre")) {
      sized.observe(box);
      box.addEventListener("scroll", () => overflow(box), {passive: true});
    }
  };

  // If the browser refuses the clipboard, the text is selected, so that one key copies it.
  const select = (text, status) => {
    getSelection().selectAllChildren(text);
    text.focus();
    status.textContent = "selected: press Ctrl+C (or Cmd+C) to copy";
  };
  const copies = (root) => {
    for (const button of root.querySelectorAll("[data-copy]")) {
      const text = button.parentElement.querySelector("pre");
      const status = button.parentElement.querySelector("[role=status]");
      button.addEventListener("click", async () => {
        try {
          await navigator.clipboard.writeText(text.textContent);
          status.textContent = "copied";
        } catch {
          select(text, status);
        }
      });
    }
  };

  const legends = (root) => {
    const narrow = matchMedia("(max-width: 620px)").matches;
    for (const methods of root.querySelectorAll(".methods")) methods.open = !narrow;
    const buttons = [...root.querySelectorAll("[data-method]")];
    const pressed = (button) => button.getAttribute("aria-pressed") === "true";
    const follow = () => {
      hidden = new Set(buttons.filter((one) => !pressed(one)).map((one) => one.dataset.method));
      restyle();
    };
    for (const button of buttons) {
      button.addEventListener("click", () => {
        button.setAttribute("aria-pressed", String(!pressed(button)));
        follow();
      });
    }
    for (const every of root.querySelectorAll("[data-every]")) {
      every.addEventListener("click", () => {
        const on = !buttons.every(pressed);
        for (const button of buttons) button.setAttribute("aria-pressed", String(on));
        every.textContent = on ? "none" : "all";
        follow();
      });
    }
    hidden = new Set(buttons.filter((one) => !pressed(one)).map((one) => one.dataset.method));
  };

  const readied = (root) => {
    scrolls(root);
    for (const table of root.querySelectorAll("table")) {
      const first = table.querySelector(".hint");
      if (first) first.tabIndex = 0;
    }
  };

  const foldings = (root) => {
    for (const details of root.querySelectorAll("details")) {
      details.addEventListener("toggle", async () => {
        const place = details.dataset.table;
        if (place && details.open) {
          delete details.dataset.table;
          details.insertAdjacentHTML("beforeend", (await held()).tables[place]);
          readied(details);
        }
        if (details.classList.contains("data")) {
          details.querySelector(".scroll")?.remove();
          if (!details.open) return;
          const area = details.parentElement.querySelector(".area");
          read(area).then((figure) => {
            details.append(tabled(area, figure));
            scrolls(details);
            overflow(details.querySelector(".scroll"));
          });
        }
      });
    }
  };
  const inSight = (area) => {
    const at = area.getBoundingClientRect();
    return open(area) && at.bottom > -500 && at.top < innerHeight + 500;
  };

  const begin = (root) => {
    drawn.forEach(remove);
    chosen = false;
    legends(root);
    foldings(root);
    copies(root);
    readied(root);
    watch(root);
  };

  // ---- one file that holds a whole site: its pages are templates, found by the ids in them ----
  const others = [...document.querySelectorAll("template[data-page]")];
  const home = others.length ? page.cloneNode(true) : null;
  const title = document.title;
  let current = "";
  // A part that several pages show is stored in one of them.
  const whole = (content) => {
    for (const gap of content.querySelectorAll("[data-from]")) {
      const held = others.map((one) => one.content.getElementById(gap.dataset.from)).find(Boolean);
      gap.replaceWith(held.cloneNode(true));
    }
    return content;
  };
  const turn = (name, content) => {
    if (name === current) return;
    current = name;
    page.replaceChildren(content);
    document.title = name ? `${page.querySelector("h1").textContent} – plumbob` : title;
    begin(page);
    document.dispatchEvent(new CustomEvent("plumbob:page", {detail: page}));
    scrollTo(0, 0);
  };
  const turned = (id) => {
    if (!others.length || !id || id === "main" || document.getElementById(id)) return;
    const from = others.find((one) => one.content.getElementById(id));
    if (from) turn(from.dataset.page, whole(from.content.cloneNode(true)));
    else if (home.querySelector(`#${CSS.escape(id)}`)) {
      const copy = document.createDocumentFragment();
      copy.append(...home.cloneNode(true).childNodes);
      turn("", copy);
    }
  };

  const follow = () => {
    const id = decodeURIComponent(location.hash.slice(1).split("?")[0]);
    turned(id || (current ? "top" : ""));
    let place = document.getElementById(id);
    const wanted = place;
    if (wanted?.matches("article.finding")) wanted.querySelector("details").open = true;
    for (; place; place = place.parentElement) if (place.tagName === "DETAILS") place.open = true;
    if (wanted) wanted.scrollIntoView();
  };
  addEventListener("hashchange", follow);

  // A printed page shows the pictures.
  addEventListener("beforeprint", () => { for (const area of drawn) { drawn.delete(area); erase(area); } });
  dark.addEventListener("change", () => {
    for (const area of drawn) queue(area, true, () => Plotly.relayout(area.stage, themed(area.given)));
  });
  begin(page);
  if (location.hash) follow();
})();
