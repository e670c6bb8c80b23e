"""What a finding's words rest on: figures of the stored study, each held to what is said of it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from plumbob.reports.view.content import Claim, Finding
from plumbob.reports.view.notation import number

CLEAR = 10.0  # a difference that words speak of is this many times what it is compared with
ALIKE = 0.2  # a figure that theory predicts may differ from that by this part of it
AGREES = 1e-3  # of a figure: what formula and engine may differ by
NOT_SHOWN = "not shown"


def at_most(what: str, found: float, bound: float, unit: str = "") -> Claim:
    """That a figure, magnitude and all, is no larger than `bound`."""
    text = f"{what} is {_with(found, unit)} and not at most {_with(bound, unit)}"
    return Claim(text, abs(found) <= bound)


def clear(what: str, large: float, small: float, unit: str = "") -> Claim:
    """That `large` is at least CLEAR times `small`, both as magnitudes."""
    text = (
        f"{what}: {_with(abs(large), unit)} beside {_with(abs(small), unit)}, less than "
        f"{CLEAR:g} times as much"
    )
    return Claim(text, abs(large) >= CLEAR * abs(small) and large != 0.0)


def as_predicted(what: str, found: float, predicted: float, unit: str = "") -> Claim:
    """That a figure is the predicted one, sign and all, within ALIKE of it."""
    text = f"{what} is {_with(found, unit)}, where {_with(predicted, unit)} is predicted"
    return Claim(text, abs(found - predicted) <= ALIKE * abs(predicted))


def between(what: str, found: float, low: float, high: float, unit: str = "") -> Claim:
    """That a figure lies in a range."""
    text = f"{what} is {_with(found, unit)} and not {number(low)} to {_with(high, unit)}"
    return Claim(text, low <= found <= high)


def as_measured(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings as a study shows them: one whose figures are not what its words say is no longer
    claimed, says which figures those are, and judges no statement of a source."""
    return tuple(_as_measured(finding) for finding in findings)


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
    found = number(value) if math.isfinite(value) else "no number"
    return f"{found} {unit}".strip()
