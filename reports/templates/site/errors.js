(() => {
  "use strict";
  // A reader chooses in which language all errors stand: as per cent, or as powers of ten. The choice is
  // kept for all pages of the site. Without a script they are per cent.
  const KEPT = "plumbob-errors", group = document.querySelector(".errors-as"), page = document.getElementById("page");
  if (!group) return;
  const buttons = [...group.querySelectorAll("button")];
  const PERCENT = /(-?\d[\d.]*(?:e-?\d+)?)[ \u00a0]%/g, SKIPPED = "code, pre, script, style, input";
  const originals = new Map();
  let observer = null;

  // Returns a number in per cent as a power of ten with the same digits: 2.5 % as 2.5e-2.
  const power = (all, text) => {
    const value = Number(text) / 100, digits = text.replace(/e.*/, "").replace(/^[-0.]+|\./g, "").length;
    const written = value.toExponential(Math.max(digits - 1, 0)).replace("e+", "e");
    return Number.isFinite(value) && value ? written.replace(/e0$/, "") : all;
  };
  const convert = (root) => {
    const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
    for (let node = root.nodeType === Node.TEXT_NODE ? root : walker.nextNode(); node; node = walker.nextNode()) {
      if (!node.data.includes("%") || node.parentElement?.closest(SKIPPED)) continue;
      const text = node.data.replace(PERCENT, power);
      if (text === node.data) continue;
      originals.set(node, [node.data, text]);
      node.data = text;
    }
  };
  const restore = () => {
    for (const [node, [before, after]] of originals) if (node.data === after) node.data = before;
    originals.clear();
  };
  const show = (as) => {
    observer?.disconnect();
    restore();
    for (const one of buttons) one.setAttribute("aria-pressed", String(one.dataset.errors === as));
    if (as !== "power") return;
    const look = {childList: true, characterData: true, subtree: true};
    convert(page);
    observer ??= new MutationObserver((changes) => {
      observer.disconnect();
      for (const {target} of changes) convert(target);
      observer.observe(page, look);
    });
    observer.observe(page, look);
  };
  // A browser may keep nothing for pages that are opened from a folder.
  const stored = () => { try { return localStorage.getItem(KEPT); } catch { return null; } };
  const store = (as) => { try { localStorage.setItem(KEPT, as); } catch { /* it stays for this page */ } };

  group.hidden = false;
  for (const one of buttons) one.addEventListener("click", () => { store(one.dataset.errors); show(one.dataset.errors); });
  const begin = () => show(stored() === "power" ? "power" : "percent");
  if (document.readyState === "loading") addEventListener("DOMContentLoaded", begin);
  else begin();
})();
