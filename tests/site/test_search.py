"""The search in a page's header: what it finds, where that leads, and by which keys."""

import json

import pytest

from plumbob.reports.cli import COMMANDS
from plumbob.reports.view.site.search import defined_terms
from plumbob.reports.view.site.writing import write_study_pages
from plumbob.tests.site import chosen
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import Document, carried_text, site_files

ACTIVE = "document.getElementById(document.activeElement.getAttribute('aria-activedescendant'))"
SCENE = "capsule-line-ca1"


@pytest.fixture(scope="module")
def entries(index):
    """Kind, name, text and address of each entry, as the site's pages load them."""
    found = json.loads(carried_text(site_files(index)[1].parent / "search.js"))
    return found


@pytest.mark.long
def test_every_scene_method_finding_and_term_is_found(entries, study, shown):
    names = {
        kind: {of[1] for of in entries if of[0] == kind} for kind in {of[0] for of in entries}
    }
    assert names["scene"] == {scene.name for scene in study.scenes}
    assert names["method"] == {method.name for method in study.methods}
    assert names["finding"] == {finding.title for finding in shown.common["findings"]}
    assert {"known limit", "not-converging", "real-time factor"} <= names["term"]
    assert len(names["system"]) == len(shown.common["views"])


@pytest.mark.long
def test_every_entry_leads_to_a_place(entries, index):
    files = {
        file.resolve(): set(Document(file.read_text("utf-8")).ids) for file in site_files(index)
    }
    folder = site_files(index)[1].parent
    for *_, place in entries:
        path, _, inside = place.partition("#")
        ids = files[(folder / path).resolve()]
        assert not inside or inside.partition("?")[0] in ids, place


@pytest.mark.long
@pytest.mark.parametrize("name", ["", SCENE])
def test_keys_open_it_choose_and_close(name, index, browser):
    page = site_files(index)[1].parent / f"{name}.html" if name else index
    with visited(browser, page) as visit:
        keys = visit.page.keyboard
        box = visit.page.locator("#find")
        keys.press("/")
        assert visit.ask("document.activeElement.id") == "find"
        keys.type("fast-pl")
        visit.page.locator("#found li").first.wait_for()
        assert "cone-pendulum/fast-platform" in visit.ask(f"{ACTIVE}.textContent")
        assert visit.violations() == []
        keys.press("Escape")
        assert (box.input_value(), visit.page.locator("#found").is_visible()) == ("", False)
        keys.press("/")
        keys.type("rk4")
        visit.page.locator("#found li").nth(1).wait_for()
        first = visit.ask(f"{ACTIVE}.id")
        keys.press("ArrowDown")
        assert visit.ask(f"{ACTIVE}.id") != first
        keys.press("ArrowUp")
        assert visit.ask(f"{ACTIVE}.id") == first
        box.fill("fast-pl")
        visit.until("document.querySelectorAll('#found li').length === 1")
        keys.press("Enter")
        visit.page.wait_for_url("**/cone-pendulum-fast-platform.html")
        assert visit.console == []
        assert all(url.startswith("file:") for url in visit.requests)


# Words that are typed, each with the entry that is found first
FOUND = {
    **dict.fromkeys(
        ("timestep", "dt", "blow up", "unstable", "step"), "The largest step I may take"
    ),
    **dict.fromkeys(("bounce", "restitution"), "Something that rolls or bounces"),
    **dict.fromkeys(("grip", "creep"), "Something that grips or stacks"),
    **dict.fromkeys(("Panda", "ur5", "integrator"), "An arm without contacts"),
    **dict.fromkeys(("Go2", "quadruped", "friction"), "A body that slides or walks"),
    **dict.fromkeys(("kv", "kp"), "A servo with kv"),
    **dict.fromkeys(("audit", "urdf", "my model"), "My own file"),
    **dict.fromkeys(("pymunk",), "pymunk"),
    **dict.fromkeys(("mujoco",), "MuJoCo"),
    **dict.fromkeys(("plumbob gradient",), "plumbob gradient"),
}


@pytest.mark.long
def test_words_of_a_reader_lead_to_a_topic(browser, tmp_path):
    index = write_study_pages(chosen.study(), tmp_path)
    with visited(browser, index) as visit:
        box = visit.page.locator("#find")
        for typed, wanted in FOUND.items():
            box.fill(typed)
            visit.until(f"document.querySelector('#found li b')?.textContent === '{wanted}'")
        box.fill("pymunk")
        visit.until("document.querySelector('#found li b')?.textContent === 'pymunk'")
        visit.page.keyboard.press("Enter")
        visit.page.wait_for_url("**/engines.html#side-by-side?a=pymunk&b=mujoco")
        said = visit.page.locator("[data-said]").inner_text()
        assert said.startswith("At 1 ms pymunk is within 1 % ")


def test_every_command_is_a_term():
    assert {name for name, _ in defined_terms("commands")} == {
        f"plumbob {of}" for of in COMMANDS
    }
