(() => {
  "use strict";
  // A reader chooses a kind of body, a step, an accepted error and a friction; the page shows the
  // advice for them. The choice is kept in the address, after "#simulate?".
  const PLACE = "#simulate";

  const begin = (root) => {
    const section = root.querySelector(PLACE);
    if (!section) return;
    const form = section.querySelector(".ask"), picks = [...section.querySelectorAll(".pick")];
    const kinds = [...section.querySelectorAll(".kind")];
    const asked = [...form.querySelectorAll("[data-ask]")], friction = asked.find((one) => one.dataset.ask === "friction");
    const values = Object.fromEntries(asked.map((one) => [one.dataset.ask, one.value]));
    const first = {kind: kinds[0].dataset.kind, ...values};
    const chosen = {...first};
    section.classList.add("chosen");
    for (const details of section.querySelectorAll(".others")) {
      const kind = details.closest(".kind"), parts = [".advice", ".copied"].flatMap((part) => [...kind.querySelectorAll(part)]);
      details.remove();
      kind.querySelector(".measured").before(...parts);
    }
    const codes = [...section.querySelectorAll("[data-contacts] :is(pre, [data-settings])")].map((one) => [one, one.textContent]);

    const show = () => {
      for (const pick of picks) {
        if (pick.dataset.kind === chosen.kind) pick.setAttribute("aria-current", "true");
        else pick.removeAttribute("aria-current");
      }
      for (const kind of kinds) kind.hidden = kind.dataset.kind !== chosen.kind;
      const kind = kinds.find((one) => !one.hidden);
      form.hidden = kind.dataset.kind === "own";
      friction.closest("label").hidden = !("contacts" in kind.dataset);
      let of = "";
      for (const advice of kind.querySelectorAll(".advice")) {
        advice.hidden = !advice.dataset.for.split(" ").includes(`${chosen.step}:${chosen.error}`);
        if (!advice.hidden) of = advice.dataset.of;
      }
      for (const copied of kind.querySelectorAll(".copied")) copied.hidden = copied.dataset.of !== of;
      const number = Number(chosen.friction) > 0 ? chosen.friction : first.friction;
      for (const one of kind.querySelectorAll(".frictions")) one.hidden = one.dataset.measured.split(" ").map(Number).includes(Number(number));
      for (const [one, text] of codes) {
        one.textContent = one.tagName !== "PRE" ? text.replace(/--friction .*/, `--friction ${number}`)
          : text.replace(/ friction="([^"]+)"/g, (_, all) => ` friction="${all.split(" ").map(() => number).join(" ")}"`);
      }
    };
    const keep = () => {
      history.replaceState(history.state, "", `${PLACE}?${new URLSearchParams(chosen)}`);
      show();
    };
    const restore = () => {
      const [place, kept] = location.hash.split("?"), kind = kinds.find((one) => `#${one.id}` === place);
      if (kind) chosen.kind = kind.dataset.kind;
      if (place === PLACE && kept) {
        const wanted = {...first, ...Object.fromEntries(new URLSearchParams(kept))};
        if (kinds.some((one) => one.dataset.kind === wanted.kind)) chosen.kind = wanted.kind;
        for (const one of asked) {
          one.value = wanted[one.dataset.ask];
          if (!one.value) one.value = first[one.dataset.ask];
          chosen[one.dataset.ask] = one.value;
        }
      }
      show();
    };

    for (const pick of picks) {
      pick.addEventListener("click", (event) => {
        event.preventDefault();
        chosen.kind = pick.dataset.kind;
        keep();
        // On a phone the cards fill the window: the answer below them comes into sight.
        const answer = form.hidden ? kinds.find((one) => !one.hidden) : form;
        if (answer.getBoundingClientRect().top > 0.6 * innerHeight) answer.scrollIntoView();
      });
    }
    for (const one of asked) {
      one.addEventListener("input", () => { chosen[one.dataset.ask] = one.value; keep(); });
    }
    form.addEventListener("submit", (event) => event.preventDefault());
    addEventListener("hashchange", restore);
    restore();
  };

  document.addEventListener("plumbob:page", ({detail}) => begin(detail));
  begin(document);
})();
