"""The table of the page "Engines" in Chromium: filtered by engine, system and kind, with the
pictures of the systems that are left, and restored from the address."""

import pytest

from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import site_files

PLACE = "#errors-and-costs"
SEEN = """() => {
  const finding = document.getElementById("errors-and-costs");
  const visible = (one) => one.checkVisibility();
  const texts = (what) => [...finding.querySelectorAll(what)].filter(visible)
    .map((one) => one.textContent.trim());
  return {scenes: texts(".matrix tbody th"),
    engines: [...new Set(texts(".matrix thead th"))].slice(1), kinds: texts(".matrix caption"),
    plots: texts(".plot b"), said: texts("[role=status]")[0]};
}"""


@pytest.mark.long
def test_it_is_filtered_by_engine_system_and_kind(index, browser):
    page = site_files(index)[1].parent / "engines.html"
    with visited(browser, page, PLACE) as visit:
        whole = visit.ask(SEEN)
        box = visit.page.locator(f"{PLACE} [data-filter]")
        box.fill("plane drake")
        by_kind = visit.ask(SEEN)
        box.fill("four-bar")
        by_system = visit.ask(SEEN)
        visit.page.locator(f"{PLACE} [data-engine=mujoco]").click()
        by_engine = visit.ask(SEEN)
        place = visit.ask("location.hash")
        assert visit.console == []
    assert len(whole["kinds"]) == 5
    assert len(whole["plots"]) == len(whole["scenes"]) == 23
    assert by_kind["kinds"] == ["Ball or box above a plane"]
    assert by_kind["engines"] == ["drake"]
    assert by_kind["plots"] == by_kind["scenes"] != []
    assert by_kind["said"] == f"{len(by_kind['scenes'])} scenes, 1 engine"
    assert [name.partition("/")[0] for name in by_system["scenes"]] == ["four-bar"]
    assert by_system["engines"] == whole["engines"]
    assert by_engine["engines"] == [name for name in whole["engines"] if name != "mujoco"]
    with visited(browser, page, place) as visit:
        assert visit.ask(SEEN) == by_engine
