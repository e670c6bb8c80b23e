"""Verdicts as JUnit XML: a case for each scene and method, with its errors as properties."""

from __future__ import annotations

from collections import Counter
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


def write_junit(file: Path, study: Study, judged: Judgements) -> None:
    """Write one test case for each scene and method: a failure where the verdict is unexpected,
    skipped with the reason where it is a known limit or claims nothing; and a failure for each
    largest step and each derivative that is unexpected."""
    suite = ElementTree.Element("testsuite", name="plumbob")
    ran = {(c.scene, c.method): c for c in study.convergence}
    counts: Counter[str] = Counter()
    for scene, method in pairs(study.scenes, study.methods):
        judgement, runs = judged[scene.name, method.name].whole, ran[scene.name, method.name]
        case = ElementTree.SubElement(
            suite,
            "testcase",
            classname=scene.name,
            name=method.name,
            time=f"{sum(m.seconds for m in runs.measurements):.6f}",
        )
        held = ElementTree.SubElement(case, "properties")
        properties = _properties(runs, study.leading(scene.name), judgement)
        for name, value in (properties | _relative(runs, method, study, scene.name)).items():
            ElementTree.SubElement(held, "property", name=name, value=value)
        if (outcome := _outcome(scene, method, judgement)) is not None:
            kind, message = outcome
            ElementTree.SubElement(case, kind, message=message)
            counts[kind] += 1
    for of in unexpected(judged_searches(study)):
        name = f"{of.method}, {of.about}"
        case = ElementTree.SubElement(suite, "testcase", classname=of.scene, name=name)
        ElementTree.SubElement(case, "failure", message=f"{of.surprise}: {of.why}")
        counts["failure"] += 1
    suite.attrib |= {
        "tests": str(len(suite)),
        "failures": str(counts["failure"]),
        "errors": "0",
        "skipped": str(counts["skipped"]),
        "time": f"{sum(study.seconds.values()):.3f}",
        "timestamp": study.provenance.date.removesuffix(" UTC").replace(" ", "T"),
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
    """Verdict and order, and the errors of the leading observable, each the largest over a run, at
    the step [s] (or relative tolerance) with the smallest and the largest of them."""
    facts = {"verdict": judgement.verdict, "observable": leading.name, "unit": leading.unit}
    if judgement.unjudged:
        facts["unjudged"] = "; ".join(f"{name}: {why}" for name, why in judgement.unjudged.items())
    by_error = sorted(
        (m.errors[leading.name].largest, m.step)
        for m in runs.measurements
        if leading.name in m.errors
    )
    for which, (error, step) in zip(
        ("smallest", "largest"), (by_error[0], by_error[-1]) if by_error else (), strict=False
    ):
        facts |= {f"{which}_error": f"{error:.6g}", f"step_of_{which}_error": f"{step:.6g}"}
    if runs.order is not None:
        facts["order"] = f"{runs.order.slope:.3f}"
    return facts
