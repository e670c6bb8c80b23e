"""JUnit XML: a case for each scene and method, or for each of other things that were judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from plumbob.engines.method import Method
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import reference_run, worst
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import pairs
from plumbob.models.scene import Observable, Scene
from plumbob.reports.judge.expectations import expected, standing, surprise
from plumbob.reports.judge.searches import judged_searches, unexpected
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.judge.verdict import Judgement
from plumbob.reports.view.page import written


@dataclass(frozen=True)
class Case:
    """A test case: what it is of, and how it ends."""

    of: str
    name: str
    seconds: float | None = None
    properties: Mapping[str, str] = field(default_factory=dict)
    outcome: tuple[str, str] | None = None  # failure, error or skipped, and why; None: it passes


def write_junit(file: Path, study: Study, judged: Judgements) -> None:
    """Write one test case for each scene and method: a failure where the verdict is unexpected,
    skipped with the reason where it is a known limit or claims nothing; and a failure for each
    largest step and each derivative that is unexpected."""
    ran, cases = {(c.scene, c.method): c for c in study.convergence}, list[Case]()
    for scene, method in pairs(study.scenes, study.methods):
        judgement, runs = judged[scene.name, method.name].whole, ran[scene.name, method.name]
        properties = _properties(runs, study.leading(scene.name), judgement)
        properties |= _relative(runs, method, study, scene.name)
        seconds = sum(m.seconds for m in runs.measurements)
        outcome = _outcome(scene, method, judgement)
        cases.append(Case(scene.name, method.name, seconds, properties, outcome))
    for of in unexpected(judged_searches(study)):
        failure = "failure", f"{of.surprise}: {of.why}"
        cases.append(Case(of.scene, f"{of.method}, {of.about}", outcome=failure))
    date = study.provenance.date.removesuffix(" UTC").replace(" ", "T")
    write_cases(file, cases, sum(study.seconds.values()), date)


def write_cases(file: Path, cases: Sequence[Case], seconds: float, date: str) -> None:
    """Write a suite of test cases that took so many `seconds` and began at a `date`."""
    suite = ElementTree.Element("testsuite", name="plumbob")
    for case in cases:
        entry = ElementTree.SubElement(suite, "testcase", classname=case.of, name=case.name)
        if case.seconds is not None:
            entry.set("time", f"{case.seconds:.6f}")
        if case.properties:
            held = ElementTree.SubElement(entry, "properties")
            for name, value in case.properties.items():
                ElementTree.SubElement(held, "property", name=name, value=value)
        if case.outcome is not None:
            kind, message = case.outcome
            ElementTree.SubElement(entry, kind, message=message)
    counts = Counter(case.outcome[0] for case in cases if case.outcome)
    suite.attrib |= {
        "tests": str(len(suite)),
        "failures": str(counts["failure"]),
        "errors": str(counts["error"]),
        "skipped": str(counts["skipped"]),
        "time": f"{seconds:.3f}",
        "timestamp": date,
    }
    text = ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True)
    written(text, file.parent, file.name)


def _outcome(scene: Scene, method: Method, judgement: Judgement) -> tuple[str, str] | None:
    """`failure` or `skipped` with its message; None for a case that passes."""
    wanted, means = expected(scene.name, method.name), standing(scene, method, judgement)
    if means == "unexpected":
        return "failure", f"{surprise(scene, method, judgement)}: {judgement.reason}"
    if means == "known limit":
        return "skipped", f"known limit, {judgement.verdict}: {wanted.reason}"
    if means == "pre-asymptotic":
        return "skipped", f"pre-asymptotic, nothing is claimed: {judgement.reason}"
    return ("skipped", f"{judgement.verdict}: {judgement.reason}") if means == "not run" else None


def _relative(runs: ConvergenceStudy, method: Method, study: Study, scene: str) -> dict[str, str]:
    """The relative error at the reference step [s] (or the tightest tolerance), of which quantity
    of interest it is, and the step."""
    shown = reference_run(runs.measurements, method)
    if shown is None:
        return {}
    quantity, error = worst(shown, study.quantities(scene))
    return {
        "relative_error": f"{error:.6g}",
        "quantity": quantity.observable,
        "step": f"{shown.step:.6g}",
    }


def _properties(
    runs: ConvergenceStudy, leading: Observable, judgement: Judgement
) -> dict[str, str]:
    """Verdict and order, and the leading observable."""
    facts = {"verdict": judgement.verdict, "observable": leading.name, "unit": leading.unit}
    if judgement.unjudged:
        facts["unjudged"] = "; ".join(f"{name}: {why}" for name, why in judgement.unjudged.items())
    return facts | ({} if runs.order is None else {"order": f"{runs.order.slope:.3f}"})
