"""Checks that figures of the stored study support a finding's text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from plumbob.reports.view.content import Claim
from plumbob.reports.view.notation import number

Claims = Sequence[Claim]  # that a finding's words rest on
CLEAR = 10.0  # a difference that words speak of is this many times what it is compared with
AGREES = 1e-3  # of a figure: what formula and engine may differ by


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


def between(what: str, measured: float, low: float, high: float, unit: str = "") -> Claim:
    """That a figure lies in a range."""
    text = f"{what} is {_with(measured, unit)} and not {number(low)} to {_with(high, unit)}"
    return Claim(text, low <= measured <= high)


def as_expected(surprises: Iterable[str]) -> Claims:
    """That nothing is unexpected."""
    return tuple(Claim(text, False) for text in surprises)


def _with(value: float, unit: str) -> str:
    amount = number(value) if math.isfinite(value) else "no number"
    return f"{amount} {unit}".strip()
