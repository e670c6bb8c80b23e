"""Every number that the index has beside "1 ms" is what a run at 1 ms gives, and a number that says
another step is what a run at that step gives."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
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
from plumbob.models.registry import case_of, scenes, systems
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.capsule_line import headings
from plumbob.reports.view import notation
from plumbob.reports.view.site import first_screen, views, writing
from plumbob.tests.support.declared import declared, nothing
from plumbob.tests.support.studies import recorded

STEP = 1e-3  # [s]
EQUAL = 0.01  # of a number, before it is rounded to its two digits
# Relative: some fifty units in the last place, which another process need not repeat.
ROUNDING = 1e-14
MATRIX, LARGEST = ": relative error at 1 ms", "Largest relative error at 1 ms"
COST = ("cost of a step, relative", "ns per step", "real-time factor at 1 ms")
Table = tuple[str, list[list[str]]]  # its caption or summary, and the text of its cells


@dataclass(frozen=True)
class Tables:
    """The tables of a page, and its paragraphs."""

    found: list[Table]
    paragraphs: list[str]


def text_of(html):
    """The text of an element."""
    return unescape(re.sub(r"<[^>]*>", "", html)).strip()


def read(html):
    """What stands on a page, whose rows and cells need no end."""
    tables = []
    for table in re.findall("<table.*?</table>", html, re.S):
        caption, *rows = re.split("<tr[^>]*>", table)
        cells = [map(text_of, re.split("<t[dh][^>]*>", row)[1:]) for row in rows]
        tables.append((text_of(caption), [list(row) for row in cells]))
    return Tables(tables, list(map(text_of, re.findall(r"<p\b.*?</p>", html, re.S))))


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
    for caption, (heads, *rows) in index.found:
        if MATRIX not in caption:
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


@pytest.mark.long
def test_every_largest_error_of_the_first_screen(study, index):
    tables = [rows for caption, rows in index.found if LARGEST in caption]
    assert len(tables) == 2
    titles = {system.title: system.name for system in systems().values()}
    for heads, *rows in tables:
        names = [head.partition(" ")[0] for head in heads[1:]]
        for name, *cells in (row for row in rows if row[0] not in COST):
            of = [s for s in study.scenes if s.name == name] or [
                s for s in study.scenes if s.system == titles[name] and not apart(s)
            ]
            for method, text in zip(names, cells, strict=True):
                assert any(run_again(study, s.name, method, text) for s in of), (name, text)
                assert all(error(s.name, method, STEP) <= number(text) * 1.06 for s in of), (
                    name,
                    method,
                )  # two digits
        cost = {row[0]: row[1:] for row in rows if row[0] in COST}
        factors = (float(factor) for factor in cost[COST[2]])
        for ns, factor in zip(cost[COST[1]], factors, strict=True):
            assert factor == pytest.approx(STEP * 1e9 / float(ns), rel=5e-3)


def apart(scene):
    """Whether a scene has a row of its own."""
    return bool(scene.hard) or scene.parameters.get("friction") == 0.0


def number(text):
    """A relative error as it is written."""
    text = text.partition(" at ")[0].replace("\xa0", " ")
    return float(text.rstrip(" %×")) / (100.0 if "%" in text else 1.0)


@pytest.mark.long
def test_every_error_in_the_sentences_of_the_first_screen(study, index):
    text = " ".join(" ".join(index.paragraphs).replace("\xa0", " ").split())
    default, euler, rk4 = first_screen.WITH_CONTACTS
    line = [s.name for s in study.scenes if s.system == "capsule-line" and not apart(s)]
    said = re.search(r"stops with an error of (\S+ %)", text)
    assert said
    assert says(said[1], max(error(name, euler, STEP) for name in line))
    said = re.search(r"With default contacts the error is (\S+ %) to (\S+ %)", text)
    assert said
    errors = [error(name, default, STEP) for name in line]
    assert says(said[1], min(errors))
    assert says(said[2], max(errors))
    named = re.findall(r"(\d\S*(?: %)?) \(on (\S+)\)(?: with (\S+[^.\s]))?", text)
    assert len(named) == 5
    for number, scene, method in named:
        assert says(number, error(scene, method or rk4, STEP)), (number, scene, method)
    held = re.search(r"leaves RK4 an error of (\S+ %?), set for the middle (\S+(?: %)?)\.", text)
    assert held
    for number, method in zip(held.groups(), first_screen.HELD, strict=True):
        assert says(number, error(first_screen.FORCED, method, STEP)), (number, method)


def test_the_errors_that_a_finding_on_the_index_has_at_1_ms():
    isotropy = headings.isotropy(declared(nothing(), headings.heading_runs))
    assert isotropy
    assert isotropy.step == STEP
    for heading in (isotropy.best, isotropy.worst):
        assert heading
        largest = error(f"capsule-line/heading-{heading.angle:03d}", headings.DEFAULT, STEP)
        assert heading.size == pytest.approx(largest, rel=EQUAL), heading
