"""Every number of the index's matrices is what a run gives at 1 ms, or at the step beside it."""

import re
from dataclasses import replace
from functools import cache
from html import unescape

import pytest

from plumbob.analytic.theory import no_theory
from plumbob.engines.registry import engine_of, installed, methods
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.cost import Cost
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import pairs
from plumbob.models.registry import case_of, scenes
from plumbob.models.registry import scene as find_scene
from plumbob.reports.view import notation
from plumbob.reports.view.site import views, writing
from plumbob.tests.support.studies import recorded

STEP = 1e-3  # [s]
EQUAL = 0.01  # of a number, before it is rounded to its two digits
# Relative: some fifty units in the last place, which another process need not repeat.
ROUNDING = 1e-14
MATRIX = ": relative error at 1 ms"


def text_of(html):
    """The text of an element."""
    return unescape(re.sub(r"<[^>]*>", "", html)).strip()


def read(html):
    """Of each table of a page its caption and the text of its cells; rows and cells need no end."""
    tables = []
    for table in re.findall("<table.*?</table>", html, re.S):
        caption, *rows = re.split("<tr[^>]*>", table)
        cells = [map(text_of, re.split("<t[dh][^>]*>", row)[1:]) for row in rows]
        tables.append((text_of(caption), [list(row) for row in cells]))
    return tables


@pytest.fixture(scope="module")
def study(shared, pytestconfig):
    """The errors of the quick profile, each pair measured as `validate` does; all costs alike."""
    option = pytestconfig.getoption
    usable = [m for m in methods(option("methods")) if installed(engine_of(m))]
    chosen = pairs(scenes(option("scenes"), "quick"), usable)
    found = tuple(shared.convergence(scene, method, "quick") for scene, method in chosen)
    ran = tuple(dict.fromkeys(scene.name for scene, _ in chosen))
    cost, seconds = Cost(1000.0, 1000.0, 1000.0, 1.0, 0.0, 5), {"errors": 1.0, "costs": 1.0}
    return Study(
        "quick",
        tuple(map(find_scene, ran)),
        tuple(usable),
        found,
        dict.fromkeys(((c.scene, c.method) for c in found), cost),
        1000.0,
        seconds,
    )


@pytest.fixture(scope="module")
def index(study, tmp_path_factory):
    """The index of that study, read, without findings and timings of trimmed models."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(views, "trimming", lambda *given: None)
        pages = writing.content(recorded(study))
    index = writing.site(pages, tmp_path_factory.mktemp("index"))
    return read(index.read_text("utf-8"))


@cache
def error(scene, method, step):
    """The relative error of a run that is made now, and held to the exact motion alone."""
    case = replace(case_of(find_scene(scene)), errors=no_theory(None))
    found, _ = measure(case, find_method(method), step)
    return relative_error(found, case.system.quantities(case))


def says(text, found):
    """Whether a number on the page is this one, but for EQUAL and the rounding to its digits."""
    if found == float("inf"):
        return text == "diverged"
    if found < ROUNDING:
        return "%" not in text and float(text) < ROUNDING
    return text in {notation.relative(found * (1.0 + part)) for part in (-EQUAL, 0.0, EQUAL)}


def steps_of(study, scene, method):
    """The steps [s] that the study ran."""
    found = next(c for c in study.convergence if (c.scene, c.method) == (scene, method))
    return [m.step for m in found.measurements]


def run_again(study, scene, method, text):
    """Whether a number is what a run gives at the step that stands beside it, or at 1 ms."""
    number, _, at = text.partition(" at ")
    given = float(re.sub(r"[^0-9.e-]", "", at)) if at else STEP
    step = min(steps_of(study, scene, method), key=lambda h: abs(h - given)) if at else STEP
    assert abs(step - given) <= 5e-4 * step, text
    return says(number, error(scene, method, step))


@pytest.mark.long
def test_every_number_of_the_matrix(study, index):
    seen, wrong = 0, []
    by_name = {(c.scene, c.method) for c in study.convergence}
    for caption, (heads, *rows) in index:
        if MATRIX not in caption or "Phenomena" in caption:  # of systems, not of scenes
            continue
        for name, *cells in rows:
            for head, cell in zip(heads[1:], cells, strict=True):
                if not cell:
                    continue
                assert (name, head) in by_name
                seen += 1
                if not run_again(study, name, head, cell[2:].replace("\n", " at ")):
                    wrong.append((name, head, cell))
    assert not wrong
    assert seen == len([c for c in study.convergence if any(m.errors for m in c.measurements)])
