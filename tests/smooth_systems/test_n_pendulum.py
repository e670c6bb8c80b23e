"""Chains of rods against 60 digits of each rod's own equations, and against their modes."""

from pathlib import Path

import numpy as np
import pytest
from mpmath import mp

from plumbob.analytic.systems.n_pendulum import NPendulum
from plumbob.tests.support.extrapolation import recorded

CASES = recorded(Path(__file__).with_name("recorded_chains.json"))


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_40_digits(case):
    count = len(case.start) // 2
    times = np.array(case.times)
    masses = case.constants[:count]
    lengths = case.constants[count:-1]
    start = case.start[:count]
    rates = case.start[count:]
    motion = NPendulum(masses, lengths, case.constants[-1], start, rates).motion
    observed = motion.observe(times)
    doubt = motion.uncertainty(times)
    for name, values in zip(observed, np.array(case.states, dtype=float).T, strict=False):
        assert np.all(np.abs(observed[name] - values) < doubt[name] + 1e-15 * np.abs(values))
        assert doubt[name].max() < 3e-13


def ends(lengths, angles):
    """The last rod's end, from the axis: along, and up."""
    rods = [length * mp.expj(angle) for length, angle in zip(lengths, angles, strict=True)]
    return mp.im(sum(rods)), -mp.re(sum(rods))


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_the_end_is_where_the_angles_put_it(case):
    count = len(case.start) // 2
    lengths, times = case.constants[count:-1], np.array(case.times)
    chain = NPendulum(
        case.constants[:count],
        lengths,
        case.constants[-1],
        case.start[:count],
        case.start[count:],
    )
    observed, doubt = chain.motion.observe(times), chain.motion.uncertainty(times)
    with mp.workdps(40):
        for k, state in enumerate(case.states):
            places = ends(lengths, [mp.mpf(angle) for angle in state[:count]])
            for name, place in zip(("tip_x", "tip_z"), places, strict=True):
                assert abs(place - mp.mpf(observed[name][k])) <= doubt[name][k] < 1e-12
