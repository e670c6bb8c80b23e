"""Double pendulums integrated with 60 digits, to hold the certified reference to; some minutes.

`python -m plumbob.tests.numerics.recorded_motions` writes recorded_motions.json: Hamilton's
equations, in angles and momenta. Two step sizes have to agree to 34 digits.
"""

from pathlib import Path

import gmpy2

from plumbob.tests.support.extrapolation import record

FILE = Path(__file__).with_suffix(".json")


def slope(m1, m2, l1, l2, g):
    """Rates of the angles and of their momenta."""

    def rates(state):
        a, b, p, q = state
        s, c = gmpy2.sin_cos(a - b)
        spread = l1 * l2 * (m1 + m2 * s * s)
        turning = p * q * s / spread
        energy = m2 * (l2 * p) ** 2 + (m1 + m2) * (l1 * q) ** 2 - 2 * m2 * l1 * l2 * p * q * c
        pull = energy * s * c / spread**2
        return [
            (l2 * p - l1 * q * c) / (l1 * spread),
            ((m1 + m2) * l1 * q - m2 * l2 * p * c) / (m2 * l2 * spread),
            -(m1 + m2) * g * l1 * gmpy2.sin(a) - turning + pull,
            -m2 * g * l2 * gmpy2.sin(b) + turning - pull,
        ]

    return rates


def motion(case):
    """The motion of masses [kg], lengths [m] and gravity [m/s^2] from angles [rad] and rates
    [rad/s], in angles and momenta."""
    m1, m2, l1, l2, g = (gmpy2.mpfr(value) for value in case.constants)
    a, b, u, w = (gmpy2.mpfr(value) for value in case.start)
    coupling = m2 * l1 * l2 * gmpy2.cos(a - b)
    momenta = [(m1 + m2) * l1**2 * u + coupling * w, m2 * l2**2 * w + coupling * u]
    return slope(m1, m2, l1, l2, g), [a, b, *momenta], case.times


def angles_and_rates(motion, state):
    """What is recorded of a state."""
    return [*state[:2], *motion[0](state)[:2]]


if __name__ == "__main__":
    record(FILE, motion, longest=0.01, digits=40, bound=1e-34, shown=angles_and_rates)
