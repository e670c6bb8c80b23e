"""Two methods side by side: the sentence and the rows from the stored runs, by other code; and the
choice in Chromium."""

import re

import pytest

from plumbob.reports.records import notation
from plumbob.reports.view.site.writing import write_study_pages
from plumbob.tests.site import chosen
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import site_files

PAIR = "mujoco/euler", "mujoco/rk4"
SAID = "document.querySelector('[data-said]').textContent"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    index = write_study_pages(chosen.study(), tmp_path_factory.mktemp("sides"))
    return site_files(index)[1].parent / "engines.html"


def _errors(method):
    """The error of a method at 1 ms on each scene, from the stored runs."""
    study = chosen.study()
    errors = {}
    for series in study.convergence:
        for run in series.measurements:
            if (run.method, run.step, run.status) == (method, 1e-3, "done"):
                errors[run.scene] = chosen.error_of(run)
    return errors


def _sentence(first, second):
    """The sentence that the page begins with, for two methods."""
    both = _errors(first), _errors(second)
    scenes = sorted(set(both[0]) & set(both[1]))
    within = [sum(errors[scene] <= 0.01 for scene in scenes) for errors in both]
    return (
        f"At 1 ms {first} is within 1 % of the exact motion on {within[0]} of the {len(scenes)} "
        f"scenes that both run, {second} on {within[1]}."
    )


def test_a_pair_of_engines_is_shown_first(page):
    text = page.read_text("utf-8")
    said = re.search(r"data-said>(.*?)</p>", text, re.S)[1]
    assert said.startswith("At 1 ms pymunk is within 1 % of the exact motion on ")
    rows = re.findall(r'<tr><th scope="row" class="scene">.*?</tr>', text, re.S)
    shown = re.search(r"of the (\d+) scenes", said)[1]
    assert len(rows) == int(shown) > 3


@pytest.mark.long
def test_a_chosen_pair_is_compared_and_kept_in_the_address(page, browser):
    with visited(browser, page) as visit:
        first = visit.ask(SAID)
        for side, name in zip("ab", PAIR, strict=True):
            visit.page.locator(f"[data-side={side}]").select_option(name)
        said, kept = visit.ask(SAID), visit.ask("location.hash")
        rows = visit.ask(
            "[...document.querySelectorAll('.sides tbody tr')].map((one) => "
            "[...one.cells].slice(0, 3).map((cell) => cell.textContent))"
        )
        arm = re.search(r"On arms up to (\S+ ?%?) against (\S+)\.", said)
        for side, name in zip("ab", ("pymunk", "mujoco"), strict=True):
            visit.page.locator(f"[data-side={side}]").select_option(name)
        assert visit.ask(SAID) == first
        assert visit.console == []
    assert said.startswith(_sentence(*PAIR))
    errors = [_errors(name) for name in PAIR]
    for scene, *texts in rows:
        assert texts == [notation.relative(of[scene]) for of in errors]
    arms = [
        max(
            of[scene]
            for scene in of
            if scene.split("/")[0] in ("servo", "linear-pendulum") and "/held-" not in scene
        )
        for of in errors
    ]
    assert list(arm.groups()) == [notation.relative(error) for error in arms]
    with visited(browser, page, kept) as visit:
        assert visit.ask(SAID) == said
