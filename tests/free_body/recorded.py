"""Free rotations integrated with 60 digits, to hold the closed form to; it takes half an hour.

`python -m plumbob.tests.free_body.recorded` writes recorded.json: Euler's equations and
q' = q w/2. Two step sizes have to agree to 26 digits.
"""

from pathlib import Path

import gmpy2

from plumbob.tests.support.extrapolation import record

FILE = Path(__file__).with_suffix(".json")


def motion(case):
    """The motion from moments [kg m^2] and an angular velocity [rad/s], in angular velocity and
    quaternion; the longest takes 10^3 periods."""
    first, second, third = (gmpy2.mpfr(value) for value in case.constants)
    factors = ((second - third) / first, (third - first) / second, (first - second) / third)

    def rates(state):
        u, v, w, a, b, d, e = state
        return [
            *(
                factor * pair
                for factor, pair in zip(factors, (v * w, w * u, u * v), strict=True)
            ),
            -(b * u + d * v + e * w) / 2,
            (a * u + d * w - e * v) / 2,
            (a * v - b * w + e * u) / 2,
            (a * w + b * v - d * u) / 2,
        ]

    return rates, [gmpy2.mpfr(value) for value in (*case.start, 1.0, 0.0, 0.0, 0.0)], case.times


if __name__ == "__main__":
    record(FILE, motion, longest=0.2, digits=25, bound=1e-26)
