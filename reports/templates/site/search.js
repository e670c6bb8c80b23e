(() => {
  "use strict";
  // The search in the header: topics, engines, scenes, methods, findings, commands and terms, from a
  // list that is loaded on demand. "/" opens it, arrows choose an entry, Enter follows it, Escape closes the search.
  const MOST = 12;
  const header = document.querySelector("header.search"), holder = document.getElementById("search");
  if (!header) return;
  header.hidden = false;
  const box = header.querySelector("input"), list = header.querySelector("ul"), status = header.querySelector("[role=status]");
  const base = holder.dataset.src ? new URL(holder.dataset.src, location.href) : location.href;
  const plain = (text) => text.toLowerCase();
  let chosen = -1;

  const choose = (place) => {
    const options = [...list.children];
    chosen = options.length ? (place + options.length) % options.length : -1;
    options.forEach((one, i) => one.setAttribute("aria-selected", String(i === chosen)));
    if (chosen < 0) return box.removeAttribute("aria-activedescendant");
    box.setAttribute("aria-activedescendant", options[chosen].id);
    options[chosen].scrollIntoView({block: "nearest"});
  };
  const close = () => {
    list.hidden = true;
    box.setAttribute("aria-expanded", "false");
    choose(0);
  };
  // An engine by its name comes first, then a topic with a word that begins with what was typed; then
  // names that begin with the first word, names that contain it, and texts.
  const rank = (words, [kind, name, text]) => {
    const typed = words.join(" "), own = plain(name);
    const first = kind === "engine" ? own.startsWith(typed) : kind === "topic" && plain(text).split(", ").some((one) => one.startsWith(typed));
    return [first ? (kind === "engine" ? -2 : -1) : own.startsWith(words[0]) ? 0 : own.includes(words[0]) ? 1 : 2, name.length];
  };
  const found = (entries) => {
    const words = plain(box.value).split(/\s+/).filter(Boolean);
    if (!words.length) return [];
    return entries.filter((one) => words.every((word) => plain(one.slice(0, 3).join(" ")).includes(word)))
      .map((one) => [rank(words, one), one])
      .sort(([a], [b]) => a[0] - b[0] || a[1] - b[1]).map(([, one]) => one);
  };
  const option = ([kind, name, text, place], i) => {
    const item = Object.assign(document.createElement("li"), {id: `found-${i}`});
    item.setAttribute("role", "option");
    const part = (tag, content, className) => item.append(Object.assign(document.createElement(tag), {textContent: content, className}));
    part("b", name, "");
    part("span", kind, "judgement");
    if (text) part("span", text, "quiet");
    item.dataset.place = place;
    return item;
  };
  const show = async () => {
    const all = found(await plumbob.once(holder, JSON.parse));
    list.replaceChildren(...all.slice(0, MOST).map(option));
    list.hidden = !all.length;
    box.setAttribute("aria-expanded", String(!list.hidden));
    status.textContent = box.value.trim() ? `${all.length || "nothing"} found` : "";
    choose(0);
  };
  const go = (item) => {
    if (!item) return;
    location.href = new URL(item.dataset.place, base).href;
    box.value = "";
    close();
    box.blur();
  };

  box.addEventListener("input", show);
  box.addEventListener("focus", show);
  box.addEventListener("blur", close);
  list.addEventListener("pointerdown", (event) => { event.preventDefault(); go(event.target.closest("li")); });
  document.addEventListener("keydown", (event) => {
    const typing = event.target.closest?.("input, select, textarea");
    if (event.key === "/" && !typing && !event.ctrlKey && !event.metaKey && !event.altKey) {
      event.preventDefault();
      box.focus();
    }
    if (event.target !== box) return;
    const act = {
      ArrowDown: () => choose(chosen + 1), ArrowUp: () => choose(chosen - 1), Enter: () => go(list.children[chosen]),
      Escape: () => { box.value = ""; close(); box.blur(); },
    }[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
})();
