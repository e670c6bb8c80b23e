"""34-digit numbers: parts that add up, choice by a condition, rounding to double and back."""

import mpmath
import numpy as np
import pytest

from plumbob.analytic.numerics.quad import PI, choose, everywhere, quad, split

MP = mpmath.MPContext()
MP.dps = 50


def exact(value):
    """A 34-digit number in mpmath."""
    return MP.mpf(str(value))


def test_choice_keeps_the_digits():
    third = quad(1.0) / 3
    values = quad(np.arange(2.0)) / 3
    assert [exact(v) for v in choose(np.array([False, True]), values, PI)] == [
        exact(PI),
        exact(third),
    ]
    assert abs(exact(PI) - MP.pi) <= MP.mpf(2) ** -110 * MP.pi
    assert choose(True, third, PI) is third
    assert choose(np.False_, third, PI) is PI
    assert everywhere(third < PI)
    assert not everywhere(quad(np.arange(3.0)) > 0)


@pytest.mark.parametrize("value", [0.1, 1234.5678, 1e-9, 1.0])
def test_parts_add_up_and_the_first_multiplies_exactly(value):
    whole = quad(value) / 3
    first, second = split(whole, 20)
    gap = exact(whole) - MP.mpf(float(first)) - MP.mpf(float(second))
    assert abs(gap) <= exact(whole) * MP.mpf(2) ** -72
    for count in (7.0, 2.0**33 - 1):
        assert MP.mpf(float(first)) * int(count) == MP.mpf(float(first) * count)
