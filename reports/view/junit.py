"""JUnit XML of a study, with a test case for each scene and method, and for each failed search."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from plumbob.engines.study.results import Study
from plumbob.reports.judge.searches import judged_searches, unexpected_searches
from plumbob.reports.view.method_results import MethodResult, Results
from plumbob.reports.view.page import TEMPLATES, write_file
from plumbob.reports.view.tables import template_environment

# characters that XML forbids even when escaped: most control characters and single surrogates
NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class JunitCase(NamedTuple):
    """A test case and its outcome."""

    of: str  # scene, written as the class of the test case
    name: str
    seconds: float
    properties: Mapping[str, str]
    outcome: str = ""  # failure, error or skipped; empty: it passes
    message: str = ""


def write_junit(file: Path, study: Study, results: Results) -> None:
    """Writes the JUnit file of a study, with a test case for each scene and method.

    An unexpected verdict is a failure. A known limit, and a verdict that claims nothing, is
    skipped, with its reason. Each unexpected largest step or derivative adds a failure."""
    searches = [
        JunitCase(
            of=search.scene,
            name=f"{search.method}, {search.about}",
            seconds=0.0,
            properties={},
            outcome="failure",
            message=f"{search.surprise}: {search.why}",
        )
        for search in unexpected_searches(judged_searches(study))
    ]
    date = study.provenance.date.removesuffix(" UTC").replace(" ", "T")
    cases = [*map(_case, results.values()), *searches]
    write_cases(file, cases, sum(case.seconds for case in cases), date)


def _case(result: MethodResult) -> JunitCase:
    """Returns the test case of a scene and a method. Its properties are the verdict, the order, the
    largest relative error at the reference step (or the tightest tolerance), the quantity with that
    error, and the step."""
    judged = result.judged
    order = result.series.order
    properties: dict[str, str] = {"verdict": judged.verdict}
    if order:
        properties["order"] = f"{order.slope:.3f}"
    run = result.reference
    if run:
        quantity, error = result.worst(run)
        properties |= {"relative_error": f"{error:.6g}", "quantity": quantity.observable}
        properties["step"] = f"{run.step:.6g}"
    outcomes = {
        "unexpected": ("failure", f"{judged.surprise}: {judged.reason}"),
        "known limit": ("skipped", f"known limit, {judged.verdict}: {judged.declared}"),
        "pre-asymptotic": ("skipped", f"pre-asymptotic, nothing is claimed: {judged.reason}"),
        "not run": ("skipped", f"{judged.verdict}: {judged.reason}"),
    }
    outcome, message = outcomes.get(judged.standing, ("", ""))
    return JunitCase(
        of=result.scene.name,
        name=result.name,
        seconds=sum(run.seconds for run in result.series.measurements),
        properties=properties,
        outcome=outcome,
        message=message,
    )


def write_cases(file: Path, cases: Sequence[JunitCase], seconds: float, date: str) -> None:
    """Writes a suite of test cases that took `seconds` in all and began at `date`."""
    template = template_environment(TEMPLATES, autoescape=True).get_template("junit.xml.jinja")
    counts = Counter(case.outcome for case in cases)
    text = template.render(cases=cases, counts=counts, seconds=seconds, date=date)
    text = NO_XML.sub(lambda held: repr(held[0])[1:-1], text)
    write_file(text, file.parent, file.name)
