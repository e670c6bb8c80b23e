"""The band of rounding along recordings: ensembles of nudged runs, real differences, and a contact
that begins within it."""

import mujoco
import numpy as np
import pytest

from plumbob.analytic.left_open import by_rounding
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.band import BandMeasurement
from plumbob.engines.difference.difference import compared_motions
from plumbob.engines.difference.recording import recording_of
from plumbob.engines.difference.repetitions import recorded_run, samples_of, start_of
from plumbob.engines.difference.sample_steps import SampleSteps, StepLaw
from plumbob.tests.audit.scenes_as_models import scene_as_model
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


EXACT_SCENES = [
    ("simple-pendulum/free-large", ("theta",)),
    ("n-pendulum/triple", ("angle_1", "angle_2", "angle_3")),
    ("projectile/thrown", ("x", "z", "angle")),
    ("linear-pendulum/overdamped", ("theta",)),
]
SAMPLES = 400  # of the band's covariance: their root mean square is known to 4 %


@pytest.mark.rare
@pytest.mark.parametrize(("scene", "names"), EXACT_SCENES, ids=[row[0] for row in EXACT_SCENES])
def test_on_exact_scenes_the_band_agrees_with_the_theory_of_rounding(scene, names):
    """The theory is an upper estimate: four standard deviations of half a unit in the last place of
    all inputs in each step, at the largest effect so far. A step rounds fewer numbers, and its
    rounding has less time to grow: the band is below the theory's deviation, and above a
    twentieth."""
    duration, step = 0.3, 1e-3
    count = round(duration / step)
    audited = scene_as_model(scene, "mujoco/euler", step, duration)
    own = audited.model
    recording = recorded_run(own, start_of(audited.script(duration, step), own), "own")
    samples = samples_of(own, recording)
    zero = np.zeros(samples.space.size(own.state))
    band = BandMeasurement(samples, Allowance(300.0), np.float64).band(0, zero)
    assert band.end == count
    values, vectors = np.linalg.eigh(band.samples[-1].covariance)
    roots = vectors * np.sqrt(np.maximum(values, 0.0))
    # Shifts a million times as large, so that their own rounding is small beside them
    drawn = 1e6 * np.random.default_rng(0).standard_normal((SAMPLES, zero.size)) @ roots.T
    states = samples.space.shifted(np.tile(recording.states[-1], (SAMPLES, 1)), drawn)
    doubt = audited.case.reference.uncertainty(recording.times)
    for name in names:
        end = audited.observed(recording.states[-1:], name)
        spread = np.sqrt(np.mean((audited.observed(states, name) - end) ** 2)) / 1e6
        deviation = by_rounding(doubt[name], count)[-1] / 4.0
        assert 0.05 < spread / deviation < 1.0, name
