(() => {
  "use strict";
  // A reader chooses two methods, or engines, in two menus; the page compares their errors scene by
  // scene. The choice is kept in the address, after "#side-by-side?".
  const PLACE = "#side-by-side";

  const begin = (root) => {
    const section = root.querySelector(PLACE);
    if (!section) return;
    const data = JSON.parse(section.querySelector("script").textContent);
    const menus = Object.fromEntries([...section.querySelectorAll("[data-side]")].map((one) => [one.dataset.side, one]));
    const said = section.querySelector("[data-said]"), body = section.querySelector("tbody");
    const [smallest, largest] = section.dataset.decades.split(" ").map(Number), within = Number(section.dataset.within);
    const kinds = JSON.parse(section.dataset.kinds);
    const size = ([error]) => (error === null ? Infinity : Math.max(error, 1e-16));
    const place = (error) => Math.min(100, Math.max(0, (100 * (Math.log10(size(error)) - smallest)) / (largest - smallest)));
    section.querySelector(".ask").hidden = false;

    const row = ([scene, a, b]) => {
      const line = document.createElement("tr"), head = document.createElement("th");
      head.scope = "row";
      head.className = "scene";
      head.append(Object.assign(document.createElement("a"), {textContent: scene, href: section.dataset.address.replace("{}", scene.replace("/", "-"))}));
      const cells = [a, b].map((one) => Object.assign(document.createElement("td"), {className: "number", textContent: one[1]}));
      const dots = Object.assign(document.createElement("td"), {className: "dots"});
      [a, b].forEach((one, i) => {
        const dot = Object.assign(document.createElement("span"), {className: `side ${"ab"[i]}`});
        dot.style.left = `${place(one)}%`;
        dots.append(dot);
      });
      line.append(head, ...cells, dots);
      return line;
    };
    const show = () => {
      const [a, b] = [menus.a.value, menus.b.value];
      const rows = data.filter(([, , of]) => of[a] && of[b]).map(([scene, kind, of]) => [scene, of[a], of[b], kind]);
      const inside = (i) => rows.filter((one) => size(one[i]) <= within).length;
      const filled = (text, words) => text.replace(/\{(\w+)\}/g, (_, name) => words[name]);
      const largest = (kind, i) => rows.filter((one) => one[3] === kind).map((one) => one[i]).reduce((one, other) => (size(other) > size(one) ? other : one))[1];
      const present = new Set(rows.map((one) => one[3]).filter(Boolean));
      const on = [...present].map((kind) => filled(section.dataset.onKind, {kind: kinds[kind], errorA: largest(kind, 1), errorB: largest(kind, 2)}));
      const words = {a, b, within: `${100 * within} %`, inA: inside(1), inB: inside(2), count: rows.length};
      said.textContent = rows.length ? [filled(section.dataset.sentence, words), ...on].join("") : `No scene was run with both ${a} and ${b}.`;
      for (const one of section.querySelectorAll("[data-name]")) one.textContent = menus[one.dataset.name].value.replace("/", "/\u200b");
      body.replaceChildren(...rows.map(row));
    };
    const restore = () => {
      const [at, kept] = location.hash.split("?");
      if (at !== PLACE || !kept) return;
      for (const [name, value] of new URLSearchParams(kept)) {
        if (menus[name] && [...menus[name].options].some((one) => one.value === value)) menus[name].value = value;
      }
      show();
    };
    for (const one of Object.values(menus)) {
      one.addEventListener("input", () => {
        history.replaceState(history.state, "", `${PLACE}?${new URLSearchParams({a: menus.a.value, b: menus.b.value})}`);
        show();
      });
    }
    addEventListener("hashchange", restore);
    restore();
  };

  document.addEventListener("plumbob:page", ({detail}) => begin(detail));
  begin(document);
})();
