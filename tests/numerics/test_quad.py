"""34 digits by numpy-quaddtype and by gmpy2's MPFR: the same numbers, and the same motions."""

import json
import pickle
import subprocess
import sys

import gmpy2
import numpy as np
import pytest

from plumbob.analytic.numerics import mpfr_numbers, quad
from plumbob.tests.support.quad_motions import observed

quaddtype_numbers = pytest.importorskip("plumbob.analytic.numerics.quaddtype_numbers")

# what numpy's functions give of one formula, of scalars and of arrays
FORMULAS = {
    "arithmetic": lambda x, y: (2 - x * y) / (y - 3.0) + (-x) ** 2 - 1 / y + abs(x - 2 * y),
    "angles": lambda x, y: np.sin(x) * np.cos(y) + np.arctan2(x, -y),
    "roots": lambda x, y: np.sqrt(x * x + y) - np.exp(-y) * np.tanh(x),
    "ends": lambda x, y: np.minimum(x, y) * np.floor(3 * y) + np.maximum(x, 2.0),
    "signs": lambda x, y: np.copysign(y, x) + np.where(x > y, x, 0.25),
}
RNG = np.random.default_rng(3)
ONE, OTHER = RNG.uniform(-2.0, 2.0, 20), RNG.uniform(0.5, 2.0, 20)


def digits(numbers, found):
    """The first 53 bits of numbers, and what is left of them."""
    high = numbers.double(found)
    return high, numbers.double(found - high)


@pytest.mark.parametrize("of", FORMULAS)
@pytest.mark.parametrize("many", [False, True])
def test_both_arithmetics_have_the_same_34_digits(of, many):
    one, other = (ONE, OTHER) if many else (float(ONE[0]), float(OTHER[0]))
    with gmpy2.context(precision=20):  # of somebody else's
        (high, low), (same, rest) = (
            digits(of_one, FORMULAS[of](of_one.quad(one) / 3, of_one.quad(other) / 7))
            for of_one in (quaddtype_numbers, mpfr_numbers)
        )
    # Eight operations of a unit in the last place, 2e-34, of numbers up to 10.
    assert np.abs((high - same) + (low - rest)).max() <= 2e-32


def test_an_array_of_mpfr_is_used_as_numpy_s_own():
    rows = mpfr_numbers.quad(np.arange(6.0).reshape(2, 3)) / 3
    assert rows.shape == (2, 3)
    assert (rows.ndim, rows.size, len(rows)) == (2, 6, 2)
    assert float(rows.sum()) == 5.0
    third = [mpfr_numbers.quad(x) / 3 for x in (0.0, 1.0, 2.0)]
    assert (rows[0] == mpfr_numbers.quad(third)).all()
    assert (np.array(third) * 3.0 == np.arange(3.0)).all()
    assert pickle.loads(pickle.dumps(rows[1, 1])) == rows[1, 1] == np.stack(list(rows))[1, 1]
    with pytest.raises(TypeError):  # would be rounded to 53 bits
        np.dot(rows, rows.reshape(3, 2))


def test_motions_are_the_same_without_quaddtype():
    hidden = (
        "import json, sys; sys.modules['numpy_quaddtype'] = None;"
        "from plumbob.analytic.numerics.quad import PI; assert type(PI).__name__ == 'Mpfr';"
        "from plumbob.tests.support.quad_motions import observed; print(json.dumps(observed()))"
    )
    assert quad.quad is quaddtype_numbers.quad
    run = subprocess.run([sys.executable, "-c", hidden], capture_output=True, check=True)
    without = json.loads(run.stdout)
    for name, motion in observed().items():
        for of, (values, doubts) in motion.items():
            same, stated = without[name][of]
            size = max(1.0, float(np.abs(values).max()))
            # the last bit of the largest: results are rounded from 34 digits
            assert np.abs(np.subtract(values, same)).max() <= 2.0**-52 * size, (name, of)
            # differences of such results: a bit of them is a part of what is stated
            assert np.allclose(doubts, stated, rtol=0.02, atol=2.0**-52 * size), (name, of)
