"""The uncertainty that exact motions state, at random parameters far from those of the scenes: the
error uses a part of it, and not a small one.

Every other set of parameters is made of numbers that are no doubles: the motion is given them
rounded, as users' numbers are. `python -m plumbob.tests.uncertainties.test_stated 100` prints what
100 sets of each system use.
"""

import math
import sys
from dataclasses import replace

import gmpy2
import mpmath
import numpy as np
import pytest
from gmpy2 import mpfr

from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.parameters import ParameterError
from plumbob.models.registry import built_in, case_of
from plumbob.tests.uncertainties.formulas import FORMULAS
from plumbob.tests.uncertainties.integrated import SMOOTH
from plumbob.tests.uncertainties.supports import ON_SUPPORTS

MOST = 0.7  # of what is stated: the rest is for motions that were not drawn
LEAST = 0.02  # of what is stated, by the median set: with less it would say nothing
BITS = 130
CALLS = 6000  # of a system's forces, each for many times
TIMES = 4
# Nothing moves in these, which is exact: a place's last digit is stated, for engines.
AT_REST = {"pinch", "stack"}
# The slider turns on a circle: from event to event, held to recorded poses and to other methods
# (tests/three_points, tests/sensitivities); repeated manoeuvres are lines.
FROM_EVENT_TO_EVENT = {"capsule-plan"}


def _drawn(name, rng):
    """A case at random, the times [s] by which little and much has happened, and its oracle."""
    if name not in SMOOTH:
        draw, formula = {**FORMULAS, **ON_SUPPORTS}[name]
        parameters, last = draw(rng)
        times = last * np.sort(rng.uniform(1e-3, 1, TIMES))
    else:
        draw, formula = SMOOTH[name]
        parameters = draw(rng)
        with gmpy2.context(gmpy2.get_context(), precision=BITS):
            step = float(formula({n: _number(v, mpfr) for n, v in parameters.items()}).step)
        times = step * np.sort(10 ** rng.uniform(-1, 1, TIMES))
    return (
        replace(built_in()[name.partition("/")[0]].scenes[0], parameters=parameters),
        times,
        formula,
    )


def _number(value, number, rng=None):
    """A parameter in many digits; with a generator, one of the numbers that are rounded to it."""
    if isinstance(value, tuple):
        return tuple(_number(part, number, rng) for part in value)
    if not isinstance(value, float) or not value:  # texts, whole numbers
        return value
    off = 0.0 if rng is None else rng.uniform(-0.49, 0.49)
    return number(value) + number(off) * number(math.ulp(value))


def _limited(reference):
    """The reference, which refuses motions that take very many steps."""
    if not isinstance(reference, CertifiedMotion):
        return reference
    left = iter(range(CALLS))
    forces = reference.system.forces

    def counted(*given):
        if next(left, None) is None:
            raise ParameterError("times", "these", "shorter")
        return forces(*given)

    return CertifiedMotion(replace(reference.system, forces=counted))


def used(name, seed):
    """The largest part that an error of a random motion has in what is stated of it."""
    rng = np.random.default_rng([seed, *name.encode()])
    for _ in range(400):
        scene, times, formula = _drawn(name, rng)
        try:
            reference = _limited(case_of(scene).reference)
            stated = reference.uncertainty(times)
            observed = reference.observe(times)
            break
        except ParameterError:  # no such body, or the motion is known for a shorter time
            continue
    rounded = rng if seed % 2 else None
    with mpmath.workdps(40), gmpy2.context(gmpy2.get_context(), precision=BITS):
        number = mpmath.mpf if name in FORMULAS else mpfr
        parameters = {n: _number(v, number, rounded) for n, v in scene.parameters.items()}
        exactly = [_number(float(time), number, rounded) for time in times]
        if name in FORMULAS:
            rows = [formula(parameters, time) for time in exactly]
            exact = {n: [row[n] for row in rows] for n in rows[0]}
        else:
            exact = formula(parameters).observed(exactly)
        return max(
            float(abs(value - number(float(seen)))) / (doubt or 1e-300)
            for n, values in exact.items()
            for value, seen, doubt in zip(values, observed[n], stated[n], strict=False)
        )


def test_every_system_is_probed():
    assert {*FORMULAS, *SMOOTH, "free-body"} | AT_REST | FROM_EVENT_TO_EVENT == {*built_in()}


def _within(name, seeds):
    parts = [used(name, seed) for seed in seeds]
    assert max(parts) <= MOST, parts
    assert np.median(parts) >= LEAST / 2, parts  # half: of a few sets


@pytest.mark.parametrize("name", FORMULAS)
def test_formulas(name):
    _within(name, range(8))


@pytest.mark.long(keep=3)
@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_motions(name):
    _within(name, range(3))


if __name__ == "__main__":
    for system in sys.argv[2:] or (*FORMULAS, *SMOOTH):
        rows = [used(system, seed) for seed in range(int(sys.argv[1]))]
        print(
            f"{system:16} {len(rows)} sets, largest {max(rows):.3f}, median {np.median(rows):.3f}",
            flush=True,
        )
