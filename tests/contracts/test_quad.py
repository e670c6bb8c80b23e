"""What the 34-digit numbers' package does for us, function by function: what an upgrade could break
without a word."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from plumbob.analytic.numerics.quad import PI, choose, double, everywhere, quad, split

MP = mpmath.MPContext()
MP.dps = 50
ROUNDING = MP.mpf(2) ** -110  # some units in the last place of 113 bits
POINTS = [0.0, 1e-300, -1e-20, 1e-7, 0.5, -1.0, 1.5707963267948966, 3.0, -100.0, 1e3, 1e22]


def exact(value: object) -> mpmath.mpf:
    """A 34-digit number in mpmath."""
    return MP.mpf(str(value))


UNARY = {"sin": MP.sin, "cos": MP.cos}


@pytest.mark.parametrize("name", UNARY)
@pytest.mark.parametrize("point", POINTS)
def test_sine_and_cosine(name: str, point: float) -> None:
    expected = UNARY[name](MP.mpf(point))
    for found in (getattr(np, name)(quad(point)), getattr(np, name)(quad(np.array([point])))[0]):
        assert abs(exact(found) - expected) <= ROUNDING * max(abs(expected), ROUNDING)


@pytest.mark.parametrize("point", [abs(x) for x in POINTS])
def test_square_root(point: float) -> None:
    expected = MP.sqrt(MP.mpf(point))
    for found in (np.sqrt(quad(point)), np.sqrt(quad(np.array([point])))[0]):
        assert abs(exact(found) - expected) <= ROUNDING * expected


@pytest.mark.parametrize("y", [-2.0, -1e-9, 0.0, 1e-20, 3.0])
@pytest.mark.parametrize("x", [-5.0, -1e-12, 1e-12, 0.25])
def test_two_argument_arctangent(x: float, y: float) -> None:
    expected = MP.atan2(MP.mpf(y), MP.mpf(x))
    with np.errstate(all="ignore"):
        scalar, array = np.arctan2(quad(y), quad(x)), np.arctan2(quad(np.array([y])), quad(x))[0]
    for found in (scalar, array):
        assert abs(exact(found) - expected) <= ROUNDING * abs(expected)


@pytest.mark.parametrize("shape", [(), (3,), (2, 1)])
def test_arithmetic(shape: tuple[int, ...]) -> None:
    """Scalars and arrays, with each other, with doubles and with integers."""
    third, tenth = MP.mpf(1) / 3, MP.mpf(0.1)
    a, b = quad(np.full(shape, 1.0)) / 3, quad(0.1)
    cases = (
        (a + b, third + tenth),
        (a - b, third - tenth),
        (a * b, third * tenth),
        (a / b, third / tenth),
        (-a, -third),
        (abs(-a), third),
        (2 * a - 1, 2 * third - 1),
        (a * 0.5, third / 2),
        (a**2, third**2),
        ((a * b) ** 4, (third * tenth) ** 4),
    )
    for found, expected in cases:
        assert np.shape(found) == shape
        for element in np.ravel(found) if shape else [found]:
            assert abs(exact(element) - expected) <= ROUNDING * abs(expected)


def test_pi_has_34_digits() -> None:
    assert abs(exact(PI) - MP.pi) <= ROUNDING * MP.pi
    assert abs(exact(quad(PI)) - MP.pi) <= ROUNDING * MP.pi


def test_selection_keeps_the_digits() -> None:
    third = quad(1.0) / 3
    values = quad(np.arange(6.0).reshape(2, 3)) / 3
    condition = np.array([[True, False, True], [False, True, False]])
    for found in (np.where(condition, values, third), choose(condition, values, third)):
        assert exact(found[1, 1]) == exact(values[1, 1])
        assert exact(found[0, 1]) == exact(third)
    order = np.array([[2, 0, 1], [1, 1, 0]])
    taken = np.take_along_axis(values, order, axis=-1)
    assert exact(taken[0, 0]) == exact(values[0, 2])
    assert exact(taken[1, 2]) == exact(values[1, 0])
    least = np.minimum(np.maximum(values, third), quad(1.0) + third)
    assert exact(least[0, 0]) == exact(third)
    assert exact(least[1, 2]) == exact(quad(1.0) + third)
    parts = np.broadcast_arrays(values, third)
    assert exact(parts[1][1, 2]) == exact(third)
    assert exact(np.stack([third, PI])[1]) == exact(PI)


def test_choice_by_a_scalar_takes_no_array() -> None:
    third = quad(1.0) / 3
    assert choose(True, third, PI) is third
    assert choose(np.False_, third, PI) is PI
    assert everywhere(third < PI)
    assert not everywhere(quad(np.arange(3.0)) > 0)


@pytest.mark.parametrize("value", [0.1, 1234.5678, 1e-9, 1.0])
def test_parts_add_up_and_the_first_multiplies_exactly(value: float) -> None:
    whole = quad(value) / 3
    first, second = split(whole, 20)
    gap = exact(whole) - MP.mpf(float(first)) - MP.mpf(float(second))
    assert abs(gap) <= exact(whole) * MP.mpf(2) ** -72
    for count in (7.0, 2.0**33 - 1):
        assert MP.mpf(float(first)) * int(count) == MP.mpf(float(first) * count)


def test_rounding_to_double_and_back() -> None:
    values = np.array([0.1, -3.0, np.inf])
    assert (double(quad(values)) == values).all()
    assert double(quad(0.1)) == 0.1
    assert np.isnan(double(quad(np.nan)))
    assert isinstance(double(quad(np.array(0.1))), float)
