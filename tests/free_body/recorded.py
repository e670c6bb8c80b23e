"""Free rotations integrated with 60 digits, to hold the closed form to; it takes half an hour.

`python -m plumbob.tests.free_body.recorded` writes recorded.json: Euler's equations and
q' = q w/2. Two step sizes have to agree to 26 digits.
"""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import Any

import gmpy2

from plumbob.tests.support.extrapolation import Motion, State, record

FILE = Path(__file__).with_suffix(".json")
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
        "symmetric": ((1.0, 1.0, 1.75), (0.4, 0.0, 2.0), (1.0, 13.0, 61.0)),
        "a needle": ((1.0, 0.9921875, 0.015625), (1.0, 2.0, 3.0), (1.0, 13.0, 111.0)),
        "a plate": ((1.0, 2.0, 3.0), (0.3, -1.0, 2.0), (1.0, 13.0, 111.0)),
    }
)


def motion(moments: Any, start: Any, times: Any) -> Motion:
    """The motion of a case in angular velocity and quaternion."""
    first, second, third = (gmpy2.mpfr(value) for value in moments)
    factors = ((second - third) / first, (third - first) / second, (first - second) / third)

    def rates(state: State) -> State:
        u, v, w, a, b, d, e = state
        return [
            *(factor * pair for factor, pair in zip(factors, (v * w, w * u, u * v), strict=True)),
            -(b * u + d * v + e * w) / 2,
            (a * u + d * w - e * v) / 2,
            (a * v - b * w + e * u) / 2,
            (a * w + b * v - d * u) / 2,
        ]

    return rates, [gmpy2.mpfr(value) for value in (*start, 1.0, 0.0, 0.0, 0.0)], times


if __name__ == "__main__":
    record(
        FILE,
        lambda: {name: motion(*case) for name, case in CASES.items()},
        longest=0.2,
        digits=25,
        bound=1e-26,
    )
