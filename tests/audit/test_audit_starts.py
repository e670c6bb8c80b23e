"""Where an audited motion starts: a keyframe, given positions and velocities, or a mjData."""

import mujoco
import numpy as np
import pytest

from plumbob import audit
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.controls import script

ROD = """<mujoco><worldbody><body><joint axis="0 1 0"/><geom size=".1" pos=".5 0 0"/></body>
</worldbody><keyframe><key name="up" qpos="-1.5" qvel="0.25"/></keyframe></mujoco>"""
SHORT = {"duration": 0.05, "budget": 1e-9}  # a start needs no reference


def start(model, **given):
    """Position and velocity at the beginning of the certified motion."""
    found = audit(model, **SHORT, **given)
    state = found.script.start
    return float(state[0]), float(state[1])


def test_a_start_is_what_is_asked_for():
    model = mujoco.MjModel.from_xml_string(ROD)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = 0.5, -2.0
    assert start(model) == (0.0, 0.0)
    assert start(model, keyframe="up") == (-1.5, 0.25)
    assert start(model, keyframe="up", qvel=[3.0]) == (-1.5, 3.0)
    assert start(model, qpos=np.array([1.0])) == (1.0, 0.0)
    assert start(data) == (0.5, -2.0)
    assert start(data, qpos=[0.75]) == (0.75, -2.0)
    assert data.qpos[0] == 0.5  # the user's own is left alone
    spec = mujoco.MjSpec.from_string(ROD)
    assert start(spec, keyframe="up") == (-1.5, 0.25)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[-1.0, 0.0, 0.0])
    with pytest.raises(ParameterError, match="model = 'MjSpec': must be one that compiles"):
        start(spec)


@pytest.mark.parametrize(
    ("given", "line"),
    [
        (
            {"qpos": [1.0, 2.0]},
            "qpos = '2 numbers': must be 1 finite numbers, as the model has",
        ),
        ({"qvel": [float("nan")]}, "must be 1 finite numbers"),
        ({"qvel": "fast"}, "qvel = 'fast': must be a list of numbers"),
    ],
)
def test_a_start_that_cannot_be_is_one_line(given, line):
    with pytest.raises(ParameterError) as caught:
        start(mujoco.MjModel.from_xml_string(ROD), **given)
    assert line in str(caught.value)


@pytest.mark.parametrize(
    ("asked", "period", "ran"),
    [
        (None, None, 1.0),
        (0.05, None, 0.06),  # periods of 20 ms
        (0.04, None, 0.04),
        (1e-9, None, 0.02),
        (0.3, 0.1, 0.3),  # 0.3/0.1 is less than 3 by rounding, 0.7/0.1 more than 7
        (0.7, 0.1, 0.7),
        (0.30001, 0.1, 0.4),
    ],
)
def test_a_duration_ends_with_its_last_period(asked, period, ran):
    model = own_model(mujoco.MjModel.from_xml_string(ROD), "m.xml")
    assert script(model, "rest", asked, period).duration == pytest.approx(ran, rel=1e-12)
    held = np.zeros((100, 0))
    if asked is not None:
        assert script(model, held, asked, period).duration == pytest.approx(ran, rel=1e-12)
