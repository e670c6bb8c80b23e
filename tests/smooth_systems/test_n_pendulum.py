"""Chains of rods against 60 digits of each rod's own equations, and against their modes."""

from pathlib import Path

import numpy as np
import pytest

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
