"""JUnit XML: a case for each scene and method, or for each of other things that were judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from plumbob.engines.study.measurement import reference_run, worst
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import pairs
from plumbob.reports.judge.expectations import expected, standing, surprise
from plumbob.reports.judge.searches import judged_searches, unexpected
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.view.page import written


class Case(NamedTuple):
    """A test case: what it is of, and how it ends."""

    of: str
    name: str
    seconds: float
    properties: Mapping[str, str]
    outcome: str = ""  # failure, error or skipped; empty: it passes
    message: str = ""


def write_junit(file: Path, study: Study, judged: Judgements) -> None:
    """Write one test case for each scene and method: a failure where the verdict is unexpected,
    skipped with the reason where it is a known limit or claims nothing; and a failure for each
    largest step and each derivative that is unexpected."""
    searches = [
        Case(of.scene, f"{of.method}, {of.about}", 0.0, {}, "failure", f"{of.surprise}: {of.why}")
        for of in unexpected(judged_searches(study))
    ]
    date = study.provenance.date.removesuffix(" UTC").replace(" ", "T")
    cases = [*_cases(study, judged), *searches]
    write_cases(file, cases, sum(study.seconds.values()), date)


def _cases(study: Study, judged: Judgements) -> Iterator[Case]:
    """Each pair, with its verdict and order, the relative error at the reference step [s] (or the
    tightest tolerance), of which quantity of interest it is, and the step."""
    ran = {(c.scene, c.method): c for c in study.convergence}
    for scene, method in pairs(study.scenes, study.methods):
        of, runs = judged[scene.name, method.name].whole, ran[scene.name, method.name]
        properties: dict[str, str] = {"verdict": of.verdict}
        if runs.order:
            properties["order"] = f"{runs.order.slope:.3f}"
        if run := reference_run(runs.measurements, method):
            quantity, error = worst(run, study.quantities(scene.name))
            properties |= {"relative_error": f"{error:.6g}", "quantity": quantity.observable}
            properties["step"] = f"{run.step:.6g}"
        outcomes = {
            "unexpected": ("failure", f"{surprise(scene, method, of)}: {of.reason}"),
            "known limit": (
                "skipped",
                f"known limit, {of.verdict}: {expected(scene.name, method.name).reason}",
            ),
            "pre-asymptotic": ("skipped", f"pre-asymptotic, nothing is claimed: {of.reason}"),
            "not run": ("skipped", f"{of.verdict}: {of.reason}"),
        }
        outcome = outcomes.get(standing(scene, method, of), ("", ""))
        seconds = sum(m.seconds for m in runs.measurements)
        yield Case(scene.name, method.name, seconds, properties, *outcome)


def write_cases(file: Path, cases: Sequence[Case], seconds: float, date: str) -> None:
    """Write a suite of test cases that took so many `seconds` and began at a `date`."""
    counts = Counter(case.outcome for case in cases)
    numbers = {"failures": "failure", "errors": "error", "skipped": "skipped"}
    suite = ElementTree.Element(
        "testsuite",
        {name: str(counts[outcome]) for name, outcome in numbers.items()},
        name="plumbob",
        tests=str(len(cases)),
        time=f"{seconds:.3f}",
        timestamp=date,
    )
    for case in cases:
        about = {"classname": case.of, "name": case.name, "time": f"{case.seconds:.6f}"}
        entry = ElementTree.SubElement(suite, "testcase", about)
        held = ElementTree.SubElement(entry, "properties")
        for name, value in case.properties.items():
            ElementTree.SubElement(held, "property", name=name, value=value)
        if case.outcome:
            ElementTree.SubElement(entry, case.outcome, message=case.message)
    text = ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True)
    written(text, file.parent, file.name)
