"""The force of a joint's spring, damper and actuators is MuJoCo's, in random states."""

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.joint_forces import (
    actuators_of,
    idle_controls,
    passive_and_actuator_force,
)

MODEL = """<mujoco><worldbody><body><joint name="hinge" {joint}/>
  <geom size="0.1" mass="1"/></body></worldbody>
  <actuator>{actuators}</actuator></mujoco>"""
SPRING = 'stiffness="3" springref="20" damping="0.7"'
MOTOR = '<motor joint="hinge" gear="2" ctrlrange="-1 1"/>'
SERVO = '<position joint="hinge" gear="1.5" kp="4" kv="0.6" forcerange="-2 2"/>'


@pytest.mark.parametrize(
    ("joint", "actuators"),
    [
        ("", ""),
        (SPRING, ""),
        ("", MOTOR),
        ("", MOTOR + SERVO),
        (SPRING, MOTOR),
        (SPRING + ' actuatorfrcrange="-1.1 1.2"', MOTOR + SERVO),
    ],
)
def test_the_force_is_mujocos(joint, actuators):
    """To rounding: the parts are as large as 10 N m, and a digit is lost where they cancel."""
    model = mujoco.MjModel.from_xml_string(MODEL.format(joint=joint, actuators=actuators))
    data = mujoco.MjData(model)
    mechanism = compiled_mechanism(model)
    force = passive_and_actuator_force(mechanism.joints[0], actuators_of(mechanism, 0))
    rng = np.random.default_rng(0)
    for controls in (idle_controls(mechanism), *rng.normal(size=(40, model.nu))):
        data.qpos[:], data.qvel[:] = rng.normal(size=2)
        data.ctrl[:] = controls
        mujoco.mj_forward(model, data)
        expected = data.qfrc_passive + data.qfrc_actuator
        got = force(float(data.qpos[0]), float(data.qvel[0]), list(controls))
        assert got == pytest.approx(float(expected[0]), abs=1e-14)
