"""Free rotations integrated with 45 digits, to hold the closed form to; it takes some minutes.

`python -m plumbob.tests.free_body.recorded` writes recorded.json: Taylor series of Euler's
equations and of q' = q w/2, of degree 60, whose steps keep the last terms below 1e-43. Every case
is integrated again in steps of 0.8 times that, but for its last time, and both have to agree to 26
digits.
"""

from __future__ import annotations

import json
from pathlib import Path
from types import MappingProxyType
from typing import Any

import gmpy2

FILE = Path(__file__).with_suffix(".json")
DIGITS, DEGREE = 45, 60
Case = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, ...]]
# moments [kg m^2], angular velocity [rad/s], times [s]; the longest is 10^3 periods
CASES: MappingProxyType[str, Case] = MappingProxyType(
    {
        "about the smallest": (
            (1.0, 2.0, 2.5),
            (1.0, 0.3, 0.2),
            (1.0, 13.0, 111.0, 1111.0, 11500.0),
        ),
        "about the largest": ((2.5, 1.0, 2.0), (-1.0, 0.3, -0.2), (1.0, 13.0, 111.0, 1200.0)),
        "next to the unstable axis": ((1.0, 2.0, 2.25), (0.02, 4.0, 0.0), (1.0, 7.0, 61.0, 1000.0)),
        "1e-3 off the separatrix": ((1.0, 2.0, 2.25), (3.003, 0.0, 4.0), (1.0, 7.0, 61.0, 300.0)),
        "1e-6 off the separatrix": ((1.0, 2.0, 2.25), (3.000003, 0.0, 4.0), (1.0, 7.0, 61.0)),
        "1e-9 off the separatrix": ((1.0, 2.0, 2.25), (3.000000003, 0.0, 4.0), (1.0, 7.0, 61.0)),
        "on the separatrix": ((1.0, 2.0, 2.25), (-3.0, 0.0, 4.0), (1.0, 4.0)),
        "nearly symmetric": ((1.0, 1.000001, 1.5), (0.4, 0.1, 2.0), (1.0, 13.0, 111.0)),
        "a needle": ((1.0, 0.9921875, 0.015625), (1.0, 2.0, 3.0), (1.0, 13.0, 111.0)),
        "a plate": ((1.0, 2.0, 3.0), (0.3, -1.0, 2.0), (1.0, 13.0, 111.0)),
    }
)


def series(moments: Any, state: list[Any]) -> list[list[Any]]:
    """Taylor coefficients of the seven numbers of a state: angular velocity and quaternion."""
    first, second, third = moments
    factors = ((second - third) / first, (third - first) / second, (first - second) / third)
    c = [[value] for value in state]
    for k in range(DEGREE):
        u, v, w, a, b, d, e = c

        def times(p: list[Any], q: list[Any], k: int = k) -> Any:
            return gmpy2.fsum([x * y for x, y in zip(p, reversed(q[: k + 1]), strict=False)])

        slopes = (
            factors[0] * times(v, w), factors[1] * times(w, u), factors[2] * times(u, v),
            -(times(b, u) + times(d, v) + times(e, w)) / 2,
            (times(a, u) + times(d, w) - times(e, v)) / 2,
            (times(a, v) - times(b, w) + times(e, u)) / 2,
            (times(a, w) + times(b, v) - times(d, u)) / 2,
        )  # fmt: skip
        for own, slope in zip(c, slopes, strict=True):
            own.append(slope / (k + 1))
    return c


def states(case: Case, part: str = "1") -> list[list[Any]]:
    """The state at each of the case's times, with steps of `part` of the longest."""
    moments = [gmpy2.mpfr(value) for value in case[0]]
    state = [gmpy2.mpfr(value) for value in (*case[1], 1.0, 0.0, 0.0, 0.0)]
    time, found = gmpy2.mpfr(0), []
    for until in case[2]:
        while time < until:
            c = series(moments, state)
            last = max(abs(own[n]) for own in c for n in (DEGREE - 1, DEGREE))
            step = (gmpy2.mpfr("1e-43") / last) ** (gmpy2.mpfr(1) / DEGREE) * gmpy2.mpfr(part)
            ends = step >= until - time
            step = until - time if ends else step
            state = [_value(own, step) for own in c]
            time = gmpy2.mpfr(until) if ends else time + step
        found.append(state)
    return found


def _value(coefficients: list[Any], step: Any) -> Any:
    total = gmpy2.mpfr(0)
    for coefficient in reversed(coefficients):
        total = total * step + coefficient
    return total


def main() -> None:
    """Integrate every case twice, and write what agrees."""
    gmpy2.get_context().precision = round(DIGITS / 0.30103)
    table = {}
    for name, case in CASES.items():
        found, again = states(case), states((case[0], case[1], case[2][:-1]), "0.8")
        for time, one, other in zip(case[2], found, again, strict=False):
            apart = max(abs(a - b) for a, b in zip(one, other, strict=True))
            assert apart < 1e-26, (name, time, apart)
        table[name] = [[f"{value:.25g}" for value in state] for state in found]
        print(name, flush=True)
    FILE.write_text(json.dumps(table, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
