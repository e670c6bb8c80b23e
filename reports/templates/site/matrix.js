(() => {
  "use strict";
  // A reader chooses rows, columns and steps in the tables of scenes by methods or engines. The choice
  // is kept in the address, after the name of the section, as "#matrix?".
  const STEPS = {"1ms": "at 1 ms", default: "at 2 ms, or a tolerance of 1e-3", "1percent": "at the largest step for 1 %"};

  const plural = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

  const begin = (root) => {
    const controls = root.querySelector(".choices");
    if (!controls) return;
    const section = controls.closest("[id]"), place = `#${section.id}`;
    const plots = [...section.querySelectorAll(".plot")].map((plot) => [plot, plot.querySelector("b").textContent]);
    const box = controls.querySelector("[data-filter]"), status = controls.querySelector("[role=status]");
    const [engines, steps] = ["engine", "step"].map((kind) => [...controls.querySelectorAll(`[data-${kind}]`)]);
    const words = Object.fromEntries([...root.querySelectorAll(".key .sign")].map((one) => {
      const [sign, ...word] = one.textContent.split(" ");
      return [sign, word.join(" ")];
    }));
    const tables = [...section.querySelectorAll(".matrix table")].map((table) => ({
      table, said: table.querySelector("[data-said]"),
      names: [...table.tHead.rows[0].cells].map((one) => one.textContent.trim()),
      rows: [...table.tBodies[0].rows].map((row) => ({row, name: row.cells[0].textContent.trim(),
        // The caption begins with the kind of system.
        words: `${row.cells[0].textContent.trim()} ${table.caption.textContent.split(":")[0]}`.toLowerCase(),
        cells: [...row.cells].map((cell) => [`${cell.innerText}~${cell.className}`, ...(cell.dataset.at || "|").split("|")])})),
    }));
    const methods = tables.flatMap(({names}) => names.slice(1)), scenes = tables.flatMap(({rows}) => rows.map((row) => row.words));
    const pressed = (button) => button.getAttribute("aria-pressed") === "true";
    const press = (button, on) => button.setAttribute("aria-pressed", String(on));

    const show = () => {
      const asked = box.value.toLowerCase().split(/\s+/).filter(Boolean);
      const of = (names) => asked.filter((word) => names.some((name) => name.includes(word)));
      const [rowWords, columnWords] = [of(scenes), of(methods)];
      const nothing = asked.some((word) => !rowWords.includes(word) && !columnWords.includes(word));
      const on = new Set(engines.filter(pressed).map((one) => one.dataset.engine));
      const step = steps.findIndex(pressed), counts = [new Set(), new Set()];
      for (const {table, said, names, rows} of tables) {
        const column = names.map((name, i) => !i || (on.has(name.split("/")[0]) && columnWords.every((word) => name.includes(word))));
        if (said) said.textContent = STEPS[steps[step].dataset.step];
        for (const {row, words: named, cells} of rows) {
          row.hidden = nothing || !rowWords.every((word) => named.includes(word));
          if (!row.hidden) cells.forEach((kept, i) => {
            const cell = row.cells[i];
            cell.hidden = !column[i];
            if (!i || !cell.dataset.at) return;
            const [text, look] = (kept[step] || "–~none").split("~");
            cell.textContent = text;
            cell.className = look;
            cell.title = words[text.split(" ")[0]] || "not reached by any step that was run";
          });
          // A row with nothing in the columns that are left says nothing.
          row.hidden ||= ![...row.cells].some((cell, i) => i && column[i] && cell.textContent.trim());
        }
        [...table.tHead.rows[0].cells].forEach((cell, i) => { cell.hidden = !column[i]; });
        const [left, across] = [rows.filter(({row}) => !row.hidden), names.filter((_, i) => i && column[i])];
        const empty = !left.length || !across.length;
        table.closest(".matrix").hidden = empty;
        if (empty) continue;
        left.forEach(({name}) => counts[0].add(name));
        across.forEach((name) => counts[1].add(name));
      }
      for (const [plot, name] of plots) plot.hidden = !counts[0].has(name);
      status.textContent = nothing ? "nothing has this name" : `${plural(counts[0].size, "scene")}, ${plural(counts[1].size, status.dataset.column)}`;
    };

    const keep = () => {
      const chosen = new URLSearchParams();
      if (box.value.trim()) chosen.set("filter", box.value.trim());
      if (!engines.every(pressed)) chosen.set("engines", engines.filter(pressed).map((one) => one.dataset.engine).join(","));
      if (steps.length && !pressed(steps[0])) chosen.set("step", steps.find(pressed).dataset.step);
      history.replaceState(history.state, "", String(chosen) ? `${place}?${chosen}` : place);
      show();
    };
    const restore = () => {
      if (!location.hash.startsWith(`${place}?`)) return;
      const chosen = new URLSearchParams(location.hash.slice(place.length + 1));
      box.value = chosen.get("filter") || "";
      const on = chosen.has("engines") ? chosen.get("engines").split(",") : null;
      for (const one of engines) press(one, !on || on.includes(one.dataset.engine));
      const step = steps.find((one) => one.dataset.step === chosen.get("step")) || steps[0];
      for (const one of steps) press(one, one === step);
      show();
    };

    box.addEventListener("input", keep);
    for (const button of engines) button.addEventListener("click", () => { press(button, !pressed(button)); keep(); });
    for (const button of steps) {
      button.addEventListener("click", () => { for (const one of steps) press(one, one === button); keep(); });
    }
    addEventListener("hashchange", restore);
    restore();
  };

  document.addEventListener("plumbob:page", ({detail}) => begin(detail));
  begin(document);
})();
