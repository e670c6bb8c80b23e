(() => {
  "use strict";
  const hidden = new Set();
  const drawn = new Set();
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  const axis = (given) => ({
    gridcolor: colour("--grid"), linecolor: colour("--rule"), zerolinecolor: colour("--rule"),
    automargin: true, ticks: "outside", tickcolor: colour("--rule"), ticklen: 4, showline: true,
    ...given, title: {standoff: 8, ...given.title, font: {size: 12}},
  });

  const themed = (layout) => {
    const full = {
      ...layout, autosize: true, hovermode: "closest",
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: {family: "system-ui, sans-serif", size: 12, color: colour("--ink")},
      modebar: {bgcolor: "rgba(0,0,0,0)", color: colour("--rule"), activecolor: colour("--ink")},
      margin: {l: 56, r: 16, t: 8, b: 44},
      hoverlabel: {bgcolor: colour("--paper"), bordercolor: colour("--rule"),
        font: {size: 12, color: colour("--ink")}, align: "left"},
      legend: {orientation: "h", x: 0, y: 1.02, yanchor: "bottom", font: {size: 12}},
    };
    for (const key of Object.keys(layout)) {
      if (/^[xy]axis\d*$/.test(key)) full[key] = axis(layout[key]);
    }
    return full;
  };

  const shown = (trace) => (hidden.has(trace.meta) ? false : true);

  const draw = (area) => {
    if (drawn.has(area)) return;
    drawn.add(area);
    const figure = JSON.parse(area.parentElement.querySelector("script").textContent);
    area.given = figure.layout;
    const data = figure.data.map((trace) => ({...trace, visible: shown(trace),
      x: figure.arrays[trace.x], y: figure.arrays[trace.y]}));
    const config = {responsive: true, displaylogo: false,
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"]};
    Plotly.newPlot(area, data, themed(figure.layout), config);
  };

  const areas = [...document.querySelectorAll(".area")];
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) if (entry.isIntersecting) draw(entry.target);
  }, {rootMargin: "400px"});
  areas.forEach((area) => seen.observe(area));

  // What is in sight comes first; the rest of what is open follows, one plot at a time.
  let waiting = 0;
  const drawNext = () => {
    const next = areas.find((area) => !drawn.has(area) && !area.closest("details:not([open])"));
    waiting = 0;
    if (!next) return;
    draw(next);
    drawSoon();
  };
  const drawSoon = () => { waiting = waiting || setTimeout(drawNext, 60); };
  for (const details of document.querySelectorAll("details")) {
    details.addEventListener("toggle", drawSoon);
  }
  drawSoon();

  const openAll = (open) => {
    for (const details of document.querySelectorAll("details.scene, details.gallery")) {
      details.open = open;
    }
  };
  for (const button of document.querySelectorAll("[data-all]")) {
    button.addEventListener("click", () => openAll(button.dataset.all === "open"));
  }

  for (const button of document.querySelectorAll("[data-method]")) {
    button.addEventListener("click", () => {
      const name = button.dataset.method;
      if (!hidden.delete(name)) hidden.add(name);
      for (const other of document.querySelectorAll("[data-method]")) {
        other.classList.toggle("off", hidden.has(other.dataset.method));
      }
      for (const area of drawn) {
        Plotly.restyle(area, {visible: area.data.map(shown)});
      }
    });
  }

  // Where the clipboard is refused, the text is selected: then one key copies it.
  const select = (text, status) => {
    getSelection().selectAllChildren(text);
    text.focus();
    status.textContent = "selected: press Ctrl+C (or Cmd+C) to copy";
  };
  for (const button of document.querySelectorAll("[data-copy]")) {
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

  const follow = () => {
    if (location.hash === "#all") {
      openAll(true);
      areas.forEach(draw);
      return;
    }
    let place = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const wanted = place;
    for (; place; place = place.parentElement) if (place.tagName === "DETAILS") place.open = true;
    if (wanted) wanted.scrollIntoView();
  };
  addEventListener("hashchange", follow);
  addEventListener("beforeprint", () => { openAll(true); areas.forEach(draw); });
  dark.addEventListener("change", () => {
    for (const area of drawn) Plotly.relayout(area, themed(area.given));
  });
  if (location.hash) follow();
})();
