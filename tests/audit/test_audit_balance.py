"""Energy, penetration and limits at the own step, against what is known of them."""

import numpy as np
import pytest

from plumbob.engines.audit import step_errors
from plumbob.tests.audit.scenes_as_models import audit_of, ball

FALLING = """<mujoco><option timestep="0.01" integrator="{}"/><worldbody>
  <body><freejoint/><geom size=".1" mass="2"/></body></worldbody></mujoco>"""
LIMITED = """<mujoco><option timestep="0.002"/><compiler angle="radian"/><worldbody>
  <body><joint axis="0 1 0" range="-1 .5"/><geom size=".1" pos=".5 0 0"/></body>
  </worldbody></mujoco>"""


@pytest.fixture
def few_steps(monkeypatch):
    """Audits at the own step and a half of it: balances are those of the own step."""
    monkeypatch.setattr(step_errors, "HALVINGS", 1)


@pytest.mark.long
@pytest.mark.usefixtures("few_steps")
def test_energy_error_of_a_fall_is_that_of_the_step():
    """Semi-implicit Euler falls g h t/2 too far with the right speed: m g^2 h t/2 too little."""
    energy, momentum = audit_of(FALLING.format("Euler"), duration=0.4).balances
    assert (energy.name, momentum.name) == ("energy", "momentum")
    assert momentum.continuous == pytest.approx(2 * 9.81 * 0.4)
    assert momentum.apart < 1e-9
    assert energy.apart == pytest.approx(2 * 9.81**2 * 0.01 * 0.4 / 2, rel=1e-6)
    assert energy.continuous < 1e-9
    exact, _ = audit_of(FALLING.format("RK4"), duration=0.4).balances
    assert exact.apart < 1e-9


@pytest.mark.long
@pytest.mark.usefixtures("few_steps")
def test_penetration_is_beside_the_continuous_one():
    found = audit_of(ball(0.11), duration=0.2)
    depth = {b.name: b for b in found.balances}["penetration"]
    assert 0.0 < depth.apart < depth.own
    lowest = 0.1 - np.min(found.model.poses(found.reference.states)[:, 1, 2])
    assert depth.continuous == pytest.approx(lowest, abs=1e-9)


@pytest.mark.long
@pytest.mark.usefixtures("few_steps")
def test_limits_that_are_exceeded_are_reported():
    names = {b.name: b for b in audit_of(LIMITED, duration=0.5).balances}
    assert names["limits exceeded"].own > 1e-4
