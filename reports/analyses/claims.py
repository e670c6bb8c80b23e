"""Checks that numbers of the stored study support the text of a finding."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from plumbob.reports.records.claim import Claim
from plumbob.reports.records.notation import number

Claims = Sequence[Claim]  # checks that support the text of a finding
CLEAR_RATIO = 10.0  # smallest ratio of two numbers whose difference a text may mention
AGREES = 1e-3  # largest relative difference between a formula and an engine that agree


def at_most(what: str, measured: float, bound: float, unit: str = "") -> Claim:
    """Returns the check that the magnitude of `measured` is at most `bound`; `what` names it."""
    text = f"{what} is {_with_unit(measured, unit)} and not at most {_with_unit(bound, unit)}"
    return Claim(text, abs(measured) <= bound)


def clearly_larger(what: str, large: float, small: float, unit: str = "") -> Claim:
    """Returns the check that |large| is at least CLEAR_RATIO times |small|; `what` names both."""
    text = (
        f"{what}: {_with_unit(abs(large), unit)} beside {_with_unit(abs(small), unit)}, less than "
        f"{CLEAR_RATIO:g} times as much"
    )
    return Claim(text, abs(large) >= CLEAR_RATIO * abs(small) and large != 0.0)


def between(what: str, measured: float, low: float, high: float, unit: str = "") -> Claim:
    """Returns the check that `measured` lies between `low` and `high`; `what` names it."""
    bounds = f"{number(low)} to {_with_unit(high, unit)}"
    text = f"{what} is {_with_unit(measured, unit)} and not {bounds}"
    return Claim(text, low <= measured <= high)


def as_expected(surprises: Iterable[str]) -> Claims:
    """Returns one failed check for each unexpected verdict; none if all verdicts are expected."""
    return tuple(Claim(text, False) for text in surprises)


def _with_unit(value: float, unit: str) -> str:
    """Returns a number with its unit as text; "no number" if it is not finite."""
    amount = number(value) if math.isfinite(value) else "no number"
    return f"{amount} {unit}".strip()
