"""Double pendulums integrated with 60 digits, to hold the certified reference to; some minutes.

`python -m plumbob.tests.numerics.recorded_motions` writes recorded_motions.json: Hamilton's
equations, in angles and momenta, by extrapolation of the modified midpoint rule to order 40 (Gragg
1965, SIAM J. Numer. Anal. 2, 384). Every case is integrated again in steps of 0.7 times the first,
and both have to agree to 34 digits.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import MappingProxyType
from typing import Any

import gmpy2

FILE = Path(__file__).with_suffix(".json")
DIGITS, COLUMNS, STEP = 60, 20, 0.01
State = list[Any]
Case = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]
# masses [kg], lengths [m] and gravity [m/s^2]; angles [rad] and rates [rad/s] at time 0; times [s]
EQUAL = (1.0, 1.0, 1.0, 1.0, 9.81)
CASES: MappingProxyType[str, Case] = MappingProxyType(
    {
        "small": (EQUAL, (0.1, 0.2, 0.0, 0.0), (0.3, 3.7, 10.0)),
        "large": (EQUAL, (1.5, 2.5, 0.0, 0.0), (0.3, 3.7, 10.0)),
        "chaotic": (EQUAL, (1.5, 2.5, 0.0, 0.0), (15.0, 20.0)),
        "next to upright": (EQUAL, (3.1, 3.14, 0.0, 0.0), (0.3, 3.7, 10.0)),
        "unequal": ((2.0, 0.05, 0.7, 0.4, 9.81), (2.0, -1.0, 1.0, -9.0), (0.3, 3.7, 10.0)),
        "weightless": ((1.0, 2.0, 0.5, 0.3, 0.0), (0.0, 0.5, 3.0, -5.0), (0.3, 3.7, 10.0)),
    }
)


def slope(constants: tuple[Any, ...]) -> Callable[[State], State]:
    """Rates of the angles and of their momenta."""
    m1, m2, l1, l2, g = constants

    def rates(state: State) -> State:
        a, b, p, q = state
        s, c = gmpy2.sin_cos(a - b)
        spread = m1 + m2 * s * s
        turning = p * q * s / (l1 * l2 * spread)
        energy = m2 * (l2 * p) ** 2 + (m1 + m2) * (l1 * q) ** 2 - 2 * m2 * l1 * l2 * p * q * c
        pull = energy * s * c / ((l1 * l2 * spread) ** 2)
        return [
            (l2 * p - l1 * q * c) / (l1 * l1 * l2 * spread),
            ((m1 + m2) * l1 * q - m2 * l2 * p * c) / (m2 * l1 * l2 * l2 * spread),
            -(m1 + m2) * g * l1 * gmpy2.sin(a) - turning + pull,
            -m2 * g * l2 * gmpy2.sin(b) + turning - pull,
        ]

    return rates


def extrapolated(rates: Callable[[State], State], state: State, step: Any) -> State:
    """The state after `step`, by Aitken and Neville's scheme in the square of the substep."""
    table: list[State] = []
    for k in range(1, COLUMNS + 1):
        row = [midpoint(rates, state, step, 2 * k)]
        for j, before in enumerate(table, start=1):
            ratio = (gmpy2.mpfr(k) / (k - j)) ** 2 - 1
            row.append([x + (x - y) / ratio for x, y in zip(row[-1], before, strict=True)])
        table = row  # row[j] extrapolates the last j + 1 results
    return table[-1]


def midpoint(rates: Callable[[State], State], state: State, step: Any, count: int) -> State:
    """Gragg's modified midpoint rule in `count` substeps, an even number."""
    h = step / count
    before, now = state, [x + h * v for x, v in zip(state, rates(state), strict=True)]
    for _ in range(count - 1):
        ahead = [x + 2 * h * v for x, v in zip(before, rates(now), strict=True)]
        before, now = now, ahead
    ends = zip(before, now, rates(now), strict=True)
    return [(x + y + h * v) / 2 for x, y, v in ends]


def states(case: Case, part: float = 1.0) -> list[State]:
    """Angles and rates at each of the case's times, in steps of `part` of the longest."""
    constants = tuple(gmpy2.mpfr(value) for value in case[0])
    m1, m2, l1, l2, _ = constants
    a, b, u, w = (gmpy2.mpfr(value) for value in case[1])
    coupling = m2 * l1 * l2 * gmpy2.cos(a - b)
    state = [a, b, (m1 + m2) * l1**2 * u + coupling * w, m2 * l2**2 * w + coupling * u]
    rates, time, found = slope(constants), gmpy2.mpfr(0), []
    for until in case[2]:
        count = int(gmpy2.ceil((until - time) / (part * STEP)))
        step = (until - time) / count
        for _ in range(count):
            state = extrapolated(rates, state, step)
        time = gmpy2.mpfr(until)
        found.append([*state[:2], *rates(state)[:2]])
    return found


def main() -> None:
    """Write what two step sizes agree on."""
    recorded = {}
    with gmpy2.context(gmpy2.get_context(), precision=int(3.33 * DIGITS)):
        for name, case in CASES.items():
            first, second = states(case), states(case, 0.7)
            apart = max(
                float(abs(x - y) / (1 + abs(x)))
                for one, other in zip(first, second, strict=True)
                for x, y in zip(one, other, strict=True)
            )
            assert apart < 1e-34, (name, apart)
            recorded[name] = [[f"{x:.40g}" for x in state] for state in second]
            print(name, apart)
    FILE.write_text(json.dumps(recorded, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
