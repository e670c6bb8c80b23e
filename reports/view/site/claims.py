"""Checks that figures of the stored study support a finding's text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import product

from plumbob.engines.method import USER_METHOD
from plumbob.engines.study.results import Study
from plumbob.reports.judge.expectations import standing
from plumbob.reports.judge.study_verdicts import Judgements
from plumbob.reports.view.content import Claim, Finding, Section
from plumbob.reports.view.notation import number

CLEAR = 10.0  # a difference that words speak of is this many times what it is compared with
ALIKE = 0.2  # a figure that theory predicts may differ from that by this part of it
AGREES = 1e-3  # of a figure: what formula and engine may differ by
MOST_NAMED = 3  # pairs of scene and method
NOT_SHOWN = "not shown"


def at_most(what: str, measured: float, bound: float, unit: str = "") -> Claim:
    """That a figure, magnitude and all, is no larger than `bound`."""
    text = f"{what} is {_with(measured, unit)} and not at most {_with(bound, unit)}"
    return Claim(text, abs(measured) <= bound)


def clear(what: str, large: float, small: float, unit: str = "") -> Claim:
    """That `large` is at least CLEAR times `small`, both as magnitudes."""
    text = (
        f"{what}: {_with(abs(large), unit)} beside {_with(abs(small), unit)}, less than "
        f"{CLEAR:g} times as much"
    )
    return Claim(text, abs(large) >= CLEAR * abs(small) and large != 0.0)


def as_predicted(what: str, measured: float, predicted: float, unit: str = "") -> Claim:
    """That a figure is the predicted one, sign and all, within ALIKE of it."""
    text = f"{what} is {_with(measured, unit)}, where {_with(predicted, unit)} is predicted"
    return Claim(text, abs(measured - predicted) <= ALIKE * abs(predicted))


def between(what: str, measured: float, low: float, high: float, unit: str = "") -> Claim:
    """That a figure lies in a range."""
    text = f"{what} is {_with(measured, unit)} and not {number(low)} to {_with(high, unit)}"
    return Claim(text, low <= measured <= high)


def formed(study: Study, judged: Judgements, section: Section, of: str) -> tuple[Finding, ...]:
    """The findings of the section `section`, of a system or `of` engines, as a study shows them. In
    place of those that cannot be formed of runs whose verdicts are unexpected, one says so."""
    shown: list[Finding | None] = []
    for finding in section.findings:
        with suppressed(study, judged):
            shown.append(finding(study))
    lacking = len(section.findings) - len(shown)
    lost = (_left_out(lacking, unexpected(study, judged), of),) if lacking else ()
    return (*as_measured(filter(None, shown)), *lost)


def as_measured(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings as a study shows them: one whose figures are not what its words say is no longer
    claimed, says which figures those are, and judges no statement of a source."""
    return tuple(_as_measured(finding) for finding in findings)


@contextmanager
def suppressed(study: Study, judged: Judgements) -> Iterator[None]:
    """Suppress errors in forming what a page shows of runs, where any of their verdicts is
    unexpected; where none is, they are defects."""
    try:
        yield
    except Exception:
        if not unexpected(study, judged):
            raise


def unexpected(study: Study, judgements: Judgements) -> list[str]:
    """Scenes and methods whose verdicts are unexpected, and users' own methods whose errors are not
    as predicted."""
    return [
        f"{scene.name} {method.name}"
        for scene, method in product(study.scenes, study.methods)
        if (judged := judgements.get((scene.name, method.name))) is not None
        and (
            standing(scene, method, judged.whole) == "unexpected"
            or (method.name == USER_METHOD and judged.whole.verdict not in ("pass", "converges"))
        )
    ]


def _left_out(count: int, pairs: Sequence[str], of: str) -> Finding:
    """In place of so many findings, with the pairs of scene and method whose runs are at fault."""
    several = "One finding is" if count == 1 else f"{count} findings are"
    named = ", ".join(pairs[:MOST_NAMED]) + (", ..." if len(pairs) > MOST_NAMED else "")
    return Finding(
        f"left-out-{of}",
        f"Not shown by this study: {count} of the findings",
        NOT_SHOWN,
        f"{several} left out, which this study's runs do not allow: verdicts are unexpected of "
        f"{named}.",
    )


def _as_measured(finding: Finding) -> Finding:
    missed = [claim.text for claim in finding.claims if not claim.holds]
    if not missed:
        return finding
    return replace(
        finding,
        title=f"Not shown by this study: {finding.title}",
        judgement=NOT_SHOWN,
        summary=f"Other studies found this, and this one does not show it: {'; '.join(missed)}.",
        statements=(),
    )


def _with(value: float, unit: str) -> str:
    amount = number(value) if math.isfinite(value) else "no number"
    return f"{amount} {unit}".strip()
