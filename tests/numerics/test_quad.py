"""34-digit numbers: parts that add up, choice by a condition, rounding to double and back."""

import mpmath
import pytest

from plumbob.analytic.numerics.quad import quad, split

MP = mpmath.MPContext()
MP.dps = 50


def exact(value):
    """A 34-digit number in mpmath."""
    return MP.mpf(str(value))


@pytest.mark.parametrize("value", [0.1, 1234.5678, 1e-9, 1.0])
def test_parts_add_up_and_the_first_multiplies_exactly(value):
    whole = quad(value) / 3
    first, second = split(whole, 20)
    gap = exact(whole) - MP.mpf(float(first)) - MP.mpf(float(second))
    assert abs(gap) <= exact(whole) * MP.mpf(2) ** -72
    for count in (7.0, 2.0**33 - 1):
        assert MP.mpf(float(first)) * int(count) == MP.mpf(float(first) * count)
