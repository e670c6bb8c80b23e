"""The matrix of the index in Chromium: filter, engines and steps, by keyboard, from the address,
and without JavaScript."""

import pytest

from plumbob.tests.support.browser import visited

SEEN = """() => {
  const visible = (one) => one.checkVisibility();
  const text = (one) => one.textContent.trim();
  const all = (what) => [...document.querySelectorAll(`.matrix ${what}`)].filter(visible).map(text);
  return {scenes: all("tbody th"), methods: [...new Set(all("thead th").slice(1))],
    cells: all("td").filter(Boolean), said: all("[data-said]")};
}"""
FOCUSED = "document.activeElement.matches('[data-filter]')"


def _reached(visit):
    """Press the tab key until the filter has the focus."""
    for _ in range(120):
        visit.page.keyboard.press("Tab")
        if visit.ask(FOCUSED):
            return
    pytest.fail("the filter cannot be reached with the tab key")


@pytest.mark.long
def test_the_keyboard_filters_and_the_address_restores(index, browser):
    with visited(browser, index) as visit:
        whole = visit.ask(SEEN)
        _reached(visit)
        visit.page.keyboard.type("capsule-line rk4")
        filtered = visit.ask(SEEN)
        visit.page.keyboard.press("Tab")  # to the engines, MuJoCo first
        visit.page.keyboard.press("Tab")
        visit.page.keyboard.press("Space")
        for _ in range(30):
            if visit.ask("document.activeElement.dataset.step") == "default":
                break
            visit.page.keyboard.press("Tab")
        visit.page.keyboard.press("Enter")
        chosen = visit.ask(SEEN)
        place = visit.ask("location.hash")
        assert visit.console == []
    assert {name.partition("/")[0] for name in filtered["scenes"]} == {"capsule-line"}
    assert filtered["methods"]
    assert all("rk4" in name for name in filtered["methods"] if name != "scene")
    assert len(filtered["cells"]) < len(whole["cells"])
    assert chosen["said"] == ["at 2 ms, or a tolerance of 1e-3"] * len(chosen["said"])
    assert "engines=" in place
    assert "pymunk" not in place
    with visited(browser, index, place) as visit:
        assert visit.ask(SEEN) == chosen
        assert visit.page.locator("[data-filter]").input_value() == "capsule-line rk4"
