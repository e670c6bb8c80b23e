"""Chains of rods integrated with 60 digits, to hold the certified reference to; a minute.

`python -m plumbob.tests.smooth_systems.recorded_chains` writes recorded_chains.json: Newton's and
Euler's equations of each rod in the plane, with the forces in the pins as unknowns. Two step sizes
have to agree to 34 digits.
"""

from pathlib import Path

import gmpy2

from plumbob.tests.support.extrapolation import record

FILE = Path(__file__).with_suffix(".json")


def slope(masses, lengths, g):
    """Rates of the angles and of their rates."""
    count = len(masses)

    def rates(state):
        rows = []  # of turns a_i, then forces (x, z) in the pin above each rod
        for i, (mass, length) in enumerate(zip(masses, lengths, strict=True)):
            line, row_x, row_z = ([gmpy2.mpfr(0)] * (3 * count + 1) for _ in range(3))
            for j in range(i + 1):  # the centre's acceleration, as those of the pins add up
                (s, c) = gmpy2.sin_cos(state[j])
                w = state[count + j]
                arm = lengths[j] / (2 if j == i else 1)
                row_x[j] = mass * arm * c
                row_z[j] = mass * arm * s
                row_x[-1] += mass * arm * s * w * w
                row_z[-1] -= mass * arm * c * w * w
            row_z[-1] -= mass * g
            (s, c) = gmpy2.sin_cos(state[i])
            line[i] = mass * length**2 / 12
            for pin, sign in ((i, 1), (i + 1, -1)):
                if pin < count:
                    x = count + 2 * pin
                    z = count + 2 * pin + 1
                    row_x[x], row_z[z] = gmpy2.mpfr(-sign), gmpy2.mpfr(-sign)
                    line[x] = length / 2 * c
                    line[z] = length / 2 * s
            rows += [row_x, row_z, line]
        return [*state[count:], *solved(rows)[:count]]

    return rates


def solved(rows):
    """Gauss's elimination, with pivots."""
    for k in range(len(rows)):
        pivot = max(range(k, len(rows)), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(len(rows)):
            if i != k and rows[i][k]:
                ratio = rows[i][k] / rows[k][k]
                rows[i] = [a - ratio * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[-1] / row[k] for k, row in enumerate(rows)]


def motion(case):
    """The motion of masses [kg], lengths [m] and gravity [m/s^2] from angles [rad] and rates."""
    count = len(case.start) // 2
    numbers = [gmpy2.mpfr(value) for value in case.constants]
    start = [gmpy2.mpfr(value) for value in case.start]
    return slope(numbers[:count], numbers[count:-1], numbers[-1]), start, case.times


if __name__ == "__main__":
    record(FILE, motion, longest=0.008, digits=40, bound=1e-34)
