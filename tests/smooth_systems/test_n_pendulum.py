"""Chains of rods against 60 digits of each rod's own equations, and against their modes."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh

from plumbob.analytic.systems.n_pendulum import NPendulum
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.recorded import recorded

CASES = recorded(Path(__file__).with_name("recorded_chains.json"))


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_40_digits(case):
    count, times = len(case.start) // 2, np.array(case.times)
    masses, lengths = case.constants[:count], case.constants[count:-1]
    start, rates = case.start[:count], case.start[count:]
    motion = NPendulum(masses, lengths, case.constants[-1], start, rates).motion
    observed, doubt = motion.observe(times), motion.uncertainty(times)
    for name, values in zip(observed, np.array(case.states, dtype=float).T, strict=False):
        assert np.all(np.abs(observed[name] - values) < doubt[name] + 1e-15 * np.abs(values))
        assert doubt[name].max() < 2e-13


def test_small_swings_are_those_of_the_modes():
    small = np.array([2e-6, 0.0, 1e-6])
    chain = case_of(scene("n-pendulum/small", {"angles": tuple(small)})).problem
    # l = 0.4 m, m = 1 kg: what hangs on each axis, in rods, times l^2 and g l
    masses = 0.16 * np.array([[7 / 3, 1.5, 0.5], [1.5, 4 / 3, 0.5], [0.5, 0.5, 1 / 3]])
    squares, modes = eigh(9.81 * 0.4 * np.diag([2.5, 1.5, 0.5]), masses)
    times = np.linspace(0.0, 2.0, 21)
    swings = np.cos(np.sqrt(squares) * times[:, None]) * (modes.T @ masses @ small) @ modes.T
    observed = chain.motion.observe(times)
    for i in range(3):  # of third order in the angle: 1e-17, some fifty times in 2 s
        np.testing.assert_allclose(observed[f"angle_{i + 1}"], swings[:, i], 0.0, 1e-15)
