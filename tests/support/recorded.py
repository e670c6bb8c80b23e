"""Motions recorded with many digits, that tests hold closed forms and certified motions to.

The states in the JSON files were integrated in gmpy2's numbers of 60 digits, by extrapolation of
the modified midpoint rule to order 40 (Gragg 1965, SIAM J. Numer. Anal. 2, 384), from equations
that share nothing with what they check: Hamilton's for double pendulums, Newton's and Euler's of
each rod for chains, Euler's and q' = q w/2 for free bodies. Two step sizes agree in every digit
that stands there, 26 or more. The derivatives in tests/sensitivities/recorded.json are central
differences, by 1e-12 of a parameter, of such motions.
"""

import json
from dataclasses import dataclass


@dataclass(frozen=True)
class Recorded:
    """A motion's constants, its start, times [s], and the state at each of them in many digits."""

    constants: tuple[float, ...]
    start: tuple[float, ...]
    times: tuple[float, ...]
    states: tuple[tuple[str, ...], ...]


def recorded(file):
    """The motions of a JSON file beside a test."""
    table = json.loads(file.read_text("utf-8"))
    return {
        name: Recorded(**{field: tuple(values) for field, values in case.items()})
        for name, case in table.items()
    }


def tuples(value):
    """A value of JSON or TOML with tuples for its lists."""
    if isinstance(value, dict):
        return {name: tuples(part) for name, part in value.items()}
    return tuple(map(tuples, value)) if isinstance(value, list) else value
