"""The band of rounding along recordings: ensembles of nudged runs, real differences, and a contact
that begins within it."""

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.band import BandMeasurement
from plumbob.engines.difference.difference import compared_motions
from plumbob.engines.difference.recording import recording_of
from plumbob.engines.difference.sample_steps import SampleSteps, StepLaw
from plumbob.tests.difference import bands
from plumbob.tests.difference.planted_changes import Motion

# Rounding within a factor of 3 of an ensemble of eight runs, whose own spread is known to 25 %
WITHIN = 3.0
# A box that lands on four stiff corners. A run in which a corner touches a step later is not a
# small change of the motion. The bound holds.
NOT_LINEAR = ("stiff contact",)
NUMBERS = [
    *(pytest.param(name, marks=pytest.mark.long) for name in bands.TEXTS),
    *(
        pytest.param(name, marks=pytest.mark.long)
        for name in ("gymnasium/half_cheetah", "gymnasium/ant", "dm_control/humanoid")
    ),
]


@pytest.mark.parametrize("name", NUMBERS)
def test_ensembles_and_real_differences_lie_within_the_bound(name):
    if name in bands.FILES:
        pytest.importorskip(name.partition("/")[0])
    _, reaches, ratio, ensemble, dense, order, *_, rounding, _ = bands.row(name)
    if name not in NOT_LINEAR:
        assert 1.0 / WITHIN < float(ratio) < WITHIN, reaches
    assert max(map(float, (ensemble, dense, order))) <= 1.0
    assert float(rounding) <= 100.0


BALL = """<mujoco><option timestep=".01"/><worldbody>
<geom name="floor" type="plane" size="9 9 1"/><body pos="0 0 {height!r}"><freejoint/>
<geom name="ball" size=".1" mass="1"/></body></worldbody></mujoco>"""


def falling(height):
    """A ball above a floor as its own model, and its recording."""
    model = mujoco.MjModel.from_xml_string(BALL.format(height=float(height)))
    own = own_model(model, "ball")
    return own, recording_of(Motion(model, 20).arrays(), "a", own)


def test_a_contact_that_begins_within_the_band_opens_it():
    """A step of free fall ends where the ball touches the floor, to within rounding."""
    own, recording = falling(0.5)
    fallen = 0.5 - recording.states[10, 2]
    own, recording = falling(0.1 + fallen)
    samples = SampleSteps(own, recording, StepLaw(own.integrator, own.step))
    band = BandMeasurement(samples, Allowance(60.0), np.float64).band(0, np.zeros(12))
    assert (band.end, band.opened) == (10, "contact floor – ball")
    assert "begins or ends within it" in band.why
    own, recording = falling(0.1 + fallen + 1e-6)
    samples = SampleSteps(own, recording, StepLaw(own.integrator, own.step))
    assert (
        not BandMeasurement(samples, Allowance(60.0), np.float64).band(0, np.zeros(12)).opened
    )


def test_a_difference_at_the_start_is_carried_as_a_term_of_its_own():
    own, recording = falling(2.0)
    arrays = {
        "time": recording.times,
        "qpos": recording.states[:, :7],
        "qvel": recording.states[:, 7:],
    }
    moved = {**arrays, "qpos": arrays["qpos"] + np.array([0, 0, 1e-6, 0, 0, 0, 0])}
    pair = (recording, recording_of(moved, "b", own))
    difference = compared_motions(own, pair, Allowance(60.0)).difference
    assert difference.at_start
    assert difference.bounds[-1] == pytest.approx(1e-6, rel=1e-4)
    assert difference.largest_use < 1.001
