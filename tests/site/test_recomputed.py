"""Every factor, ratio and error that the pages print is worked out again from the stored runs, by
code that shares nothing with the pages; and commands of the pages print what the pages print."""

import json
import re
import shlex
from collections import Counter
from copy import copy
from dataclasses import replace

import pytest

from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study import store
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import matching_scenes
from plumbob.reports.analyses import analyses_of
from plumbob.reports.analyses.analysis import Section
from plumbob.reports.analyses.capsule_line.displacement import DISPLACEMENT_ERRORS
from plumbob.reports.analyses.engines.through_contact import THROUGH_CONTACT
from plumbob.reports.cli import main
from plumbob.reports.records.page_records import ENGINES_SECTION
from plumbob.reports.view.finding_text import read_findings
from plumbob.reports.view.site.writing import write_study_pages
from plumbob.tests.sharing.shared import shared
from plumbob.tests.site.printed import Site, agrees, commands, plain
from plumbob.tests.site.stored_runs import AT, StoredRuns
from plumbob.tests.support.stored import save

SCENES = (
    "capsule-line/ca1,capsule-line/heading-000,capsule-line/heading-030,"
    "cone-pendulum/rotating-base,simple-pendulum/free-large,linear-pendulum/overdamped"
)
METHODS = "mujoco/euler,mujoco/rk4,mujoco/euler+coulomb,mujoco/rk4+coulomb,ode/dop853"
RUN_AGAIN = 10  # number of commands that are run


def _measured():
    """A study of scenes with and without contacts, with the records of its pages, a finding about
    errors at all steps and one about derivatives."""
    study = run_study(
        matching_scenes(SCENES, "quick"),
        find_methods(METHODS),
        requests=THROUGH_CONTACT.requests,
        command="plumbob",
    )
    sections = {
        "capsule-line": Section((DISPLACEMENT_ERRORS,)),
        ENGINES_SECTION: Section((THROUGH_CONTACT,)),
    }
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("plumbob.reports.analyses.section", sections.get)
        return replace(study, analyses=analyses_of(study))


@pytest.fixture(name="site", scope="module")
def _site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recomputed")
    study = shared("recomputed-study", _measured)
    save(study, folder / store.FILE)
    stored = store.load(folder / store.FILE)
    return Site(write_study_pages(stored, folder), StoredRuns(folder / store.FILE))


KINDS = {
    "blocks",
    "of runs",
    "derivative",
    "error",
    "tenth",
    "ms",
    "real time",
    "times",
    "order",
    "run",
    "reached",
    "count",
    "range",
}
# Numbers that earlier pages printed and the runs contradict: (kind, page, text of the page, text
# in its place). A pattern stands for the number beside it.
LINE, CONE = "capsule-line-ca1", "cone-pendulum-rotating-base"
PLANTED = {
    "order of another error": (
        "tenth",
        LINE,
        r"divides it by 100",
        "divides it by 10",
    ),
    "factor of other steps": (
        "tenth",
        CONE,
        r"divides it by [\d.]+",
        "divides it by 20",
    ),
    "smaller step": (
        "error",
        CONE,
        r"(error is 0.14 % at <span class=nowrap>)2e-5<",
        r"\g<1>5e-5<",
    ),
    "default error": ("error", LINE, r"error is 2.4 %", "error is 2.5 %"),
    "end for the way": ("error", LINE, r">1.6 %(?=\n1.00)", ">0.011 %"),
    "order at the end": ("order", LINE, r"(?<=\n)2.00 \(2.00\)", "1.00 (1.00)"),
    "theory's order": (
        "order",
        CONE,
        r"(?<=\n1.00 )\(1.00\)",
        "(2.00)",
    ),
    "range at one step": (
        "range",
        "capsule-line",
        r"have an error of [\d.]+.%",
        "have an error of 2.6 %",
    ),
    "count of too large steps": (
        "count",
        "index",
        r"<p class=\"tally\">",
        r'<p class="tally">? marks 6 cells ',
    ),
    "count of verdicts": ("count", "index", r"= (\d+) as predicted", r"= 1\1 as predicted"),
    "count of runs": ("count", "index", r"<b>(\d+) runs", r"<b>1\1 runs"),
    "cost of another step": (
        "ms",
        LINE,
        r"\(([\d.]+) ms of computing",
        r"(1\1 ms of computing",
    ),
    "real time": ("real time", LINE, r"([\d.]+)× real time", r"2\1× real time"),
    "times the default": (
        "times",
        LINE,
        r"([\d.]+) times the computing",
        r"1\1 times the computing",
    ),
    "zero crossing": (
        "reached",
        CONE,
        r">0.1 %(?=</button>)",
        ">0.01 %",
    ),
    "cell at the default step": ("error", "index", r'data-at="= 14 %', 'data-at="= 13 %'),
    "largest accurate step": ("error", "index", r"\|= 0.7 %", "|= 0.8 %"),
    "derivative of one run": (
        "derivative",
        "engines",
        r"error is -?\d+ % on",
        "error is -56 % on",
    ),
    "two blocks of one name": (
        "blocks",
        "cheapest",
        "MJCF and a line of Python after compiling, for bodies that also turn",
        "MJCF alone, for bodies that slide without turning",
    ),
    "another step than recommend": ("of runs", LINE, r", of the steps that were run", ""),
    "error of a run": ("run", "linear-pendulum-overdamped", r">0.00188<", ">0.00187<"),
}
UNSUPPORTED = ("nothing else running", "Bold: the smallest", "bold: the cheapest")


@pytest.mark.long
def test_every_number_of_the_pages_is_that_of_the_stored_runs(site):
    compared = list(site.compared())
    assert [one for one in compared if not agrees(one)] == []
    counted = Counter(one.kind for one in compared)
    # Each kind stands on the pages: a pattern that finds nothing would check nothing.
    assert set(counted) == KINDS
    assert counted["error"] > 100
    assert counted["order"] > 80


@pytest.mark.long
@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_contradiction_is_found(site, name):
    kind, page, text, instead = PLANTED[name]
    changed = re.sub(text, instead, site.pages[page].replace("\u00a0", " "))
    assert changed != site.pages[page].replace("\u00a0", " ")
    other = copy(site)
    other.pages = {**site.pages, page: changed}
    found = [one.kind for one in other.compared() if not agrees(one)]
    assert kind in found


@pytest.mark.long
def test_nothing_is_claimed_that_no_study_stores(site):
    for name, text in site.pages.items():
        assert [words for words in UNSUPPORTED if words in plain(text)] == [], name


@pytest.mark.long
def test_commands_print_what_the_pages_print(site, capsys):
    """The commands are those that the pages print, and those of cells of the table of errors, up to
    RUN_AGAIN."""
    asked = commands(site.pages)
    asked += [
        f"plumbob run {scene} {method} --step {AT}"
        for scene, method in sorted(site.stored.series)
        if site.stored.controls[method] == "step" and AT in site.stored.runs(scene, method)
    ]
    asked = list(dict.fromkeys(asked))[:RUN_AGAIN]
    assert len(asked) == RUN_AGAIN
    for command in asked:
        _, *arguments = shlex.split(command)
        main([*arguments, "--json"])
        found = json.loads(capsys.readouterr().out)
        stored = site.stored.run_near(found["scene"], found["method"], found["step"])
        error = site.stored.error(found["scene"], stored)
        assert found["relative_error"] == pytest.approx(error, rel=1e-12), command


@pytest.mark.parametrize(
    ("verdicts", "title"),
    [
        ({"predicted": 4}, "Errors of derivatives are as predicted in 4 of 4 cases"),
        (
            {"predicted": 2, "off-prediction": 1, "unsupported": 3},
            "Errors of derivatives are as predicted in 2 of 3 cases",
        ),
    ],
)
def test_the_finding_on_derivatives_counts_those_that_are_predicted(verdicts, title):
    """Derivatives without a number are not counted."""
    nothing = {
        "step": 1e-3,
        "way": "central",
        "of": "x",
        "by": "y",
        "computed": None,
        "why": "",
    }
    about = {"scene": "s/t", "method": "m/n", "expected": True, "known_limit": "", **nothing}
    records = [
        {**about, "verdict": verdict} for verdict, n in verdicts.items() for _ in range(n)
    ]
    (finding,) = read_findings("engines/gradients", {"records": records, "verdicts": verdicts})
    assert finding.title == title
    assert f"{sum(verdicts.values())} derivatives of end states" in finding.summary
