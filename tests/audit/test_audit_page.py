"""The page of an audit stands alone, says what the text says, and is drawn from what was found."""

import json
import re
from dataclasses import replace
from html import unescape
from math import inf
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest

from plumbob.reports.advice.audit_advice import AuditAdvice, audit_advice, halving
from plumbob.reports.advice.audit_summary import audit_summary
from plumbob.reports.cli import main
from plumbob.reports.records.notation import metres
from plumbob.reports.view.audit.html import audit_html
from plumbob.reports.view.audit.page import (
    answer_rows,
    audit_answer,
    audit_page,
    audit_report,
    card_lines,
    short_lines,
)
from plumbob.tests.audit.scenes_as_models import PENDULUM, audit_of, ball
from plumbob.tests.support.browser import visited
from plumbob.tests.support.first_verdicts import FIRST_VERDICT, without_first_verdict


@pytest.fixture(name="found", scope="module")
def _found():
    return audit_of(ball(0.12), duration=0.2)


def _html(audit):
    """The page of an audit as HTML."""
    return audit_html(audit_page(audit_answer(audit), audit, ""))


@pytest.mark.long
def test_the_card_says_the_error_the_choice_and_the_certificate(found):
    """Its lines are MJCF that sets what the row of what to do says."""
    said, *change = card_lines(found)
    lines = dict(answer_rows(audit_answer(found)))
    wrong, choice = said.split("; ")
    error = lines["your error"].partition(" (")[0]
    assert wrong == f"up to {error} wrong within 0.2 s, known to ±{metres(found.uncertainty)}"
    options = ElementTree.fromstring("\n".join(change)).attrib
    assert options
    for name, value in options.items():
        assert f'{name}="{value}"' in choice
        assert f'{name}="{value}" in place of ' in lines["to do"]
    shown = unescape(re.sub("<[^>]+>", "", _html(found)))
    assert f"U{wrong[1:]}." in shown.replace("\u00a0", " ")


@pytest.mark.long
def test_the_page_begins_with_what_is_wrong_and_what_to_do(found):
    """Then the error over time, with what the reference leaves open, and all lines."""
    text = _html(found)
    places = ['class="headline', 'class="tiles"', "What makes it better", "Error over time"]
    places += ["uncertainty of the reference", "The answer", "Every run"]
    assert [text.index(place) for place in places] == sorted(text.index(p) for p in places)
    assert len(re.findall(r'<li class="tile (?:good|fair|bad|unknown)">', text)) == 4


@pytest.mark.long
def test_fixes_are_sorted_by_what_they_gain_each_with_its_cost(found):
    advice = audit_advice(found)
    fixes = audit_summary(found, advice, halving(found)).fixes
    gains = [fix.gain for fix in fixes]
    assert gains == sorted(gains, reverse=True)
    assert len(gains) > 1
    for fix in fixes:
        # The error of a fix is the largest at its step and at all smaller steps that were run.
        runs = [
            run.at(found.found.index)
            for run in found.found.steps
            if run.integrator == fix.choice.integrator and run.step <= fix.choice.step
        ]
        assert fix.gain == found.error / max(runs)
    rows = audit_report(found).fixes.rows
    assert len(rows) == len(fixes)
    assert sum("to paste" in row[0].text for row in rows) == 1


@pytest.mark.long
@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_terminal_has_eight_lines_that_end_at_words(found, width):
    lines = short_lines(found, width)
    assert len(lines) <= 8
    assert all(len(line) <= width for line in lines[1:])
    names = [line.split("  ")[0] for line in lines if not line.startswith(" ")]
    assert names[1:3] == ["error", "to do"]
    assert names[-1] == "all lines"
    assert "--verbose" in lines[-1]
    words = " ".join(" ".join(lines).split())
    report = audit_report(found)
    assert report.headline in words
    assert all(fix in words for fix in report.advised)


@pytest.mark.long
def test_an_unstable_step_comes_first(found):
    limit = replace(found.stability.own, largest_step=0.0005, confirmed=True, holds_to=None)
    unstable = replace(found, stability=replace(found.stability, limits=(limit,)))
    lines = short_lines(unstable, 80)
    assert lines[1].split(maxsplit=1) == ["stability", "1 ms is unstable: up to 500 µs"]
    assert lines[2].startswith("error ")


@pytest.mark.long
def test_warnings_that_do_not_fit_are_counted(found, monkeypatch):
    report = audit_report(found)
    long = " ".join(["many"] * 40)
    more = replace(report, warnings=(long, long, long))
    monkeypatch.setattr("plumbob.reports.view.audit.page.audit_report", lambda audit: more)
    lines = short_lines(found, 80)
    assert len(lines) <= 8
    assert re.search(r"--verbose: [2-5] more, and all numbers$", lines[-1])


GRADES = [
    ({"error": 5e-4}, "accuracy", "good"),
    ({"error": 5e-3}, "accuracy", "fair"),
    ({"error": 5e-2}, "accuracy", "bad"),
    ({"error": inf}, "accuracy", "bad"),
    ({"found": None}, "accuracy", "unknown"),
    ({"outcome": "helps"}, "smaller step", "good"),
    ({"outcome": "hardly helps"}, "smaller step", "fair"),
    ({"outcome": "does not help"}, "smaller step", "bad"),
    ({"outcome": "diverges"}, "smaller step", "bad"),
    ({"near_limit": 0.011}, "stability", "fair"),
    ({"unstable": True}, "stability", "bad"),
    ({"stability": None}, "stability", "unknown"),
    ({}, "stability", "good"),
    ({}, "model", "good"),
    ({"more_iterations": True}, "model", "fair"),
    ({"raised": ("geom a",)}, "model", "bad"),
]


@pytest.mark.parametrize(("changes", "question", "grade"), GRADES)
def test_grades_are_decided_by_what_was_found(changes, question, grade):
    """The four answers are graded in Python; the page gives each grade a colour and a word."""
    known = {"found": object(), "still": False, "error": 5e-4, "uncertainty": 1e-6}
    own = SimpleNamespace(confirmed=True, holds_to=None)
    stability = SimpleNamespace(unstable=changes.get("unstable", False), own=own)
    audit = SimpleNamespace(**{**known, "stability": stability, **changes})
    names = ("near_limit", "more_iterations", "raised")
    advice = AuditAdvice("steps", **{name: changes[name] for name in names if name in changes})
    halved = SimpleNamespace(outcome=changes.get("outcome", "helps")) if audit.found else None
    assert dict(audit_summary(audit, advice, halved).grades)[question] == grade


@pytest.mark.long
def test_command_writes_the_page_and_names_the_model_as_it_was_given(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    Path("arm").mkdir()
    Path("arm/rod.xml").write_text(PENDULUM.format(integrator="Euler"), "utf-8")
    short = ["audit", "arm/rod.xml", "--duration", "0.1", "--budget", "1"]
    assert main([*short, "--out", "pages"]) == 0
    printed = capsys.readouterr()
    assert printed.err.startswith(f"{FIRST_VERDICT}estimate about ")
    assert without_first_verdict(printed.err).strip() == "pages/audit-rod.html"
    assert printed.out.startswith("rod.xml ")
    page = Path("pages/audit-rod.html").read_text("utf-8")
    assert "plumbob audit arm/rod.xml --duration 0.1" in page
    assert main([*short, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["model"] == "arm/rod.xml"
    assert main([*short, "--out", "arm/rod.xml"]) == 2
    assert capsys.readouterr().err.startswith("plumbob: out = 'arm/rod.xml'")


FALLING = """<mujoco><option timestep="0.005"/><worldbody>
<geom name="floor" type="plane" size="5 5 .1"/>
<body pos="0 0 .15"><freejoint/><geom name="box" type="box" size=".2 .1 .1" mass="2"/>
<body pos=".2 0 .1"><joint name="arm" axis="0 1 0" damping=".05"/>
<geom name="rod" type="capsule" fromto="0 0 0 .3 0 .1" size=".03" mass=".5"/></body></body>
</worldbody></mujoco>"""


@pytest.mark.long
def test_the_page_of_a_model_with_contacts_is_printed_on_one_sheet(tmp_path, browser, capsys):
    """One sheet of A4 or of Letter holds the replay and the table of all lines."""
    (tmp_path / "box.xml").write_text(FALLING, "utf-8")
    short = ["--duration", "0.4", "--budget", "5", "--out", str(tmp_path)]
    assert main(["audit", str(tmp_path / "box.xml"), *short]) == 0
    assert len(capsys.readouterr().out.splitlines()) <= 8
    with visited(browser, tmp_path / "audit-box.html") as visit:
        for paper in ("A4", "Letter"):
            printed = visit.page.pdf(format=paper)
            assert len(re.findall(rb"/Type\s*/Page\b", printed)) == 1, paper
        assert visit.violations() == []
        assert visit.console == []
