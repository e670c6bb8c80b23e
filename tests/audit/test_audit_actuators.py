"""Actuators whose forces MuJoCo works out with the step: their continuous motion has none."""

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified
from plumbob.engines.own_motion import NotCertifiable
from plumbob.tests.audit.scenes_as_models import compiled

BUDGET = 60.0  # [s], far more than these take
DURATION = 0.5  # [s]
FINE = 256  # times smaller than the model's own steps, of 2 ms
# Forces that look ahead make all integrators first order: 4.3e-3 m at the own step, at most, for
# the corners at the arm's end, 0.32 m from its axis.
NEAR = 1.7e-5  # [m]
ARM = """
<mujoco>
  <option timestep="0.002"/>
  <extension><plugin plugin="mujoco.pid"/></extension>
  <worldbody><body><joint name="j" axis="0 1 0" damping=".05"/>
    <geom type="capsule" size=".02" fromto="0 0 0 .3 0 0"/></body></worldbody>
  <actuator>{}</actuator>
</mujoco>
"""
DCMOTOR = '<dcmotor joint="j" motorconst=".5" resistance="2" ctrlrange="-1 1" {}/>'
PLUGIN = """<plugin plugin="mujoco.pid" joint="j" actdim="{}" ctrlrange="{}"><config key="kp"
  value="2"/><config key="ki" value="1"/><config key="imax" value="1"/>{}</plugin>"""
ACTUATORS = {
    "a filter that looks ahead": """<general joint="j" dyntype="filter" dynprm=".05" gainprm="2"
      actearly="true" ctrlrange="-1 1"/>""",
    "an integrator that looks ahead": """<general joint="j" dyntype="integrator" gainprm="5"
      biastype="affine" biasprm="0 -5 -1" actrange="-3 3" ctrlrange="-1 1" actearly="true"/>""",
    "a dcmotor with inductance": DCMOTOR.format('inductance=".02"'),
    "a dcmotor with a slew rate": DCMOTOR.format('input="pos" controller="5 0 .1 20"'),
    "a dcmotor with all of it": DCMOTOR.format(
        'input="pos" controller="5 2 .1 20 1" inductance=".02" lugre="50 1 .1 .15 .1" '
        'thermal="10 5 .004"'
    ),
    "a pid with a slew rate": """<pid joint="j" kp="2" ki="1" kv=".1" slewmax="3" imax="1"
      input="pos" ctrlrange="-1 1"/>""",
    "a pid of a plugin": PLUGIN.format(1, "-1 1", ""),
}


def arm(actuator):
    return own_model(compiled(ARM.format(actuator)), "arm")


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", ACTUATORS)
def test_certified_where_small_steps_tend(name):
    own = arm(ACTUATORS[name])
    motion = script(own, "sines", DURATION)
    found = certified(own, motion, Allowance(BUDGET))
    assert found.until == pytest.approx(DURATION)
    assert found.uncertainty[-1] < 1e-7
    for integrator in ("euler", "rk4"):
        fine = own.corners(own.stepped(motion, integrator, 10 * FINE).states)
        assert np.abs(fine - found.corners).max() < NEAR
        coarse = own.corners(own.stepped(motion, integrator, 10).states)
        # a field with the step is seen
        assert np.abs(coarse - found.corners).max() > 4 * NEAR


def test_a_force_that_looks_ahead_moves_as_one_that_does_not():
    """To the last bit: continuously there is no next step to look at."""
    ahead = ACTUATORS["a filter that looks ahead"]
    here, there = (
        certified(own, script(own, "sines", 0.1), Allowance(BUDGET)).corners
        for own in map(arm, (ahead, ahead.replace('actearly="true"', "")))
    )
    assert np.array_equal(here, there)


def test_a_setpoint_arrives_when_its_rate_says():
    """From 0 to 0.3 at 20 a second: after 15 ms, and it stays there to the last bit."""
    own = arm(ACTUATORS["a dcmotor with a slew rate"])
    field = own.field()
    start = np.zeros(own.state.size)
    field.hold(np.array([0.3]), 1.0, start)
    for t, setpoint, rate in ((1.0, 0.0, 20.0), (1.01, 0.2, 20.0), (1.016, 0.3, 0.0)):
        assert field(t, start)[-1] == rate
        assert field.data.act[0] == pytest.approx(setpoint, abs=1e-15)
    field.hold(np.array([-5.0]), 2.0, field.normalised(np.array([0.0, 0.0, 0.3])))
    field(2.9, start)
    assert field.data.act[0] == -1.0  # its range ends there


@pytest.mark.parametrize("controls", ["-1 1", "-1 0"])
def test_a_plugins_slew_limit_is_refused(controls):
    """Its first step sets the setpoint at once, however short it is: no motion is continuous."""
    slew = '<config key="slewmax" value="3"/>'
    with pytest.raises(NotCertifiable, match="a plugin with a slew limit"):
        arm(PLUGIN.format(2, controls, slew))
