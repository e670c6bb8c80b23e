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
from plumbob.models.registry import built_in_systems, case_of
from plumbob.tests.uncertainties.formulas import FORMULAS
from plumbob.tests.uncertainties.integrated import SMOOTH
from plumbob.tests.uncertainties.supports import ON_SUPPORTS

MOST = 0.7  # of what is stated: the rest is for motions that were not drawn
LEAST = 0.02  # of what is stated, by the median set: with less it would say nothing
BITS = 130
CALLS = 6000  # of a system's forces, each for many times
TIMES = 4
SLOW = {"servo/saturated"}  # an oracle that takes a second a set
# Nothing moves in these, which is exact: a place's last digit is stated, for engines.
AT_REST = {"pinch", "stack"}
# Made of turns, lines and strokes, which are probed one by one; its poses are held to recorded
# ones and to other methods (tests/three_points).
OF_PARTS = {"capsule-plan"}
# The last place of a blunt apex angle: 0.85 is used where only its moments' own are counted.
BLUNT = 57
# Of motions on three supports. Newton's method had ended too early, by ten times what was stated;
# the error of a coarser computation is no larger; the heading feels the roundings of velocities.
HARD = {"capsule-turn": (6, 21), "capsule-coast/spin": (6, 26)}


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
        replace(built_in_systems()[name.partition("/")[0]].scenes[0], parameters=parameters),
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
        except ParameterError:  # no such body, or the motion is known for a shorter time
            continue
        exact = _exactly(name, formula, scene.parameters, times, rng if seed % 2 else None)
        if exact:  # an oracle may know the motion up to some time alone
            break
    return max(
        float(abs(value - type(value)(float(seen)))) / (doubt or 1e-300)
        for n, values in exact.items()
        for value, seen, doubt in zip(values, observed[n], stated[n], strict=False)
    )


def _exactly(name, formula, given, times, rounded):
    """The oracle's observables, by name; with a generator `rounded` of numbers that are not the
    given ones but are rounded to them."""
    with mpmath.workdps(40), gmpy2.context(gmpy2.get_context(), precision=BITS):
        number = mpmath.mpf if name in FORMULAS else mpfr
        parameters = {n: _number(v, number, rounded) for n, v in given.items()}
        exactly = [_number(float(time), number, rounded) for time in times]
        if name not in FORMULAS:
            return formula(parameters).observed(exactly)
        rows = [formula(parameters, time) for time in exactly]
        return {n: [row[n] for row in rows] for n in rows[0]}


def test_every_system_is_probed():
    probed = {n.partition("/")[0] for n in (*FORMULAS, *SMOOTH, *ON_SUPPORTS)}
    assert {*probed, "free-body"} | AT_REST | OF_PARTS == {*built_in_systems()}


def _within(name, seeds):
    parts = [used(name, seed) for seed in seeds]
    assert max(parts) <= MOST, parts
    assert np.median(parts) >= LEAST / 2, parts  # half: of a few sets


@pytest.mark.parametrize("name", sorted({*FORMULAS} - SLOW))
def test_formulas(name):
    _within(name, range(8))


@pytest.mark.long(keep=3)
@pytest.mark.parametrize("name", [*SMOOTH, *sorted(SLOW)])
def test_smooth_motions(name):
    _within(name, range(3))


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", ON_SUPPORTS)
def test_motions_on_three_supports(name):
    _within(name, (0, 1, *HARD[name]))


def test_a_blunt_cone():
    assert used("cone-pendulum", BLUNT) <= MOST


@pytest.mark.parametrize("seed", range(8))
def test_rest_is_exact(seed):
    """Of what friction holds nothing moves, whatever the numbers: the place that is stated is for
    engines."""
    rng = np.random.default_rng(seed)
    size, mass, gravity = (
        float(10 ** rng.uniform(*ends)) for ends in ((-2, 0), (-2, 2), (-1, 2))
    )
    most = float(rng.uniform(0.01, 1)) * 10
    friction = mass * gravity / 2 / most / float(rng.uniform(0.01, 0.999))
    pinched = {"friction": friction, "normal_force": most, "finger_mass": mass}
    stacked = {"count": int(rng.integers(2, 30)), "mass_ratio": float(10 ** rng.uniform(-3, 3))}
    body = {"size": size, "mass": mass, "gravity": gravity}
    for name, more in (("pinch", pinched), ("stack", stacked)):
        scene = replace(built_in_systems()[name].scenes[0], parameters={**body, **more})
        times = rng.uniform(0, 1e3, 5)
        reference = case_of(scene).reference
        for n, values in reference.observe(times).items():
            assert not values.any()
            assert (reference.uncertainty(times)[n] > 0).all()


if __name__ == "__main__":
    for system in sys.argv[2:] or (*FORMULAS, *SMOOTH, *ON_SUPPORTS):
        rows = [used(system, seed) for seed in range(int(sys.argv[1]))]
        print(
            f"{system:16} {len(rows)} sets, largest {max(rows):.3f}, median {np.median(rows):.3f}",
            flush=True,
        )
