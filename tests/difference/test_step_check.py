"""Steps of recordings that are not the model's: planted changes are found at their sample with
their term, and recordings as they are have no finding."""

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.difference.recording import recording_of
from plumbob.engines.difference.sample_steps import SampleSteps, StepLaw
from plumbob.engines.difference.step_check import check_steps
from plumbob.tests.audit.robots.robot_files import folder
from plumbob.tests.difference.planted_changes import (
    LEGS,
    PLANTS,
    ROW,
    Motion,
    control_of,
    gravity,
    halved,
    integrator,
    other_integrator,
    pushed,
    sines,
)

# The search for a factor leaves a thousandth of what the factor causes (REST): of 1e-6. A factor of
# 1 + 1e-6 is planted, so that neither 1 nor 1 + 2e-6 would pass.
FACTOR, KNOWN = 1.0 + 1e-6, 1e-9
# Steps are differences of times of at most 1 s, which are rounded to 1e-16 s: of 1 ms, 1e-13.
STEP_ROUNDED = 1e-12
ROBOTS = [
    *(("gymnasium", name) for name in ("half_cheetah", "humanoid", "ant", "walker2d")),
    *(("dm_control", name) for name in ("humanoid", "walker")),
]


def compiled(name):
    """A leg by its name, or a robot by its package and file."""
    if name in LEGS:
        return mujoco.MjModel.from_xml_string(LEGS[name])
    package, file = name
    pytest.importorskip(package)
    return mujoco.MjModel.from_xml_path(str(folder(package) / f"{file}.xml"))


def checked(model, arrays):
    own = own_model(model, "model")
    return check_steps(own, recording_of(arrays, "a", own), Allowance(60.0))


def named(name):
    return name if isinstance(name, str) else name[1]


both = pytest.mark.parametrize("name", [*LEGS, *ROBOTS], ids=named)


@pytest.mark.long(keep=2)
@both
@pytest.mark.parametrize("plant", PLANTS)
def test_a_planted_change_is_found_with_its_term(name, plant):
    model = compiled(name)
    arrays, (row, kind, part) = PLANTS[plant](model)
    (finding,) = checked(model, arrays).findings
    assert (finding.interval, finding.cause.kind) == (row, kind)
    assert part in finding.cause.part
    if kind == "factor":
        assert finding.cause.factor == pytest.approx(FACTOR, abs=KNOWN)


@pytest.mark.long(keep=1)
@both
def test_a_push_of_100_thresholds_is_found_and_one_of_a_tenth_is_not(name):
    """The threshold is known from both sides: a push of 100 times it is found, as is promised, and
    a tenth of what rounding alone allows, its own mean square, is not."""
    model = compiled(name)
    own = own_model(model, "model")
    motion = Motion(model)
    recording = recording_of(motion.arrays(warm=True), "a", own)
    samples = SampleSteps(own, recording, StepLaw(own.integrator, own.step))
    before = samples.before(ROW, motion.warm[ROW])
    allowed = samples.allowed(before, ROW).whole
    degree = model.nv // 2
    by = allowed[model.nv + degree]
    (finding,) = checked(
        model, Motion(model, at=ROW, other=pushed(degree, 100 * by)).arrays()
    ).findings
    assert (finding.interval, finding.place) == (ROW, samples.steps.place_names[degree])
    assert finding.cause.kind == "joint"
    small = 0.1 * samples.allowed(before, ROW).rounding[model.nv + degree]
    assert not checked(
        model, Motion(model, at=ROW, other=pushed(degree, small)).arrays()
    ).findings


@pytest.mark.long(keep=0)
@both
def test_what_holds_throughout_is_recognised(name):
    model = compiled(name)
    own = StepLaw(own_model(model, "model").integrator, model.opt.timestep)
    late = checked(model, Motion(model, other=control_of(1)).arrays())
    assert (late.law.shift, late.law.integrator, late.findings) == (-1, own.integrator, ())
    other, number = other_integrator(model)
    changed = checked(model, Motion(model, other=integrator(number)).arrays())
    assert (changed.law.integrator, changed.law.step) == (other, own.step)
    assert not changed.findings
    finer = checked(model, halved(model))
    assert finer.law.step == pytest.approx(own.step / 2.0, rel=STEP_ROUNDED)
    assert not finer.findings
    heavier = checked(model, Motion(model, other=gravity(FACTOR)).arrays())
    # At its start the walker's feet touch the floor to within rounding: that step may be any.
    assert heavier.findings[0].interval <= 1
    assert heavier.common.part == "gravity"
    assert heavier.common.factor == pytest.approx(FACTOR, abs=KNOWN)


@pytest.mark.long(keep=0)
@both
def test_single_precision_is_recognised(name):
    model = compiled(name)
    own = own_model(model, "model")
    arrays = Motion(model, precision="f4").arrays()
    assert recording_of(arrays, "a", own).resolution.words == "single"
    assert not checked(model, arrays).findings
    in_double = recording_of(arrays, "a", own, precision="float64")
    assert check_steps(own, in_double, Allowance(60.0)).findings


@pytest.mark.long(keep=2)
@both
@pytest.mark.parametrize(
    "shape", ["as it is", "warm", "from the middle", "each fourth", "6 digits"]
)
def test_a_recording_as_it_is_has_no_finding(name, shape):
    """Five recordings of each of nine models, and more by `untouched`."""
    model = compiled(name)
    assert not checked(model, untouched(model, shape, 0)).findings


def untouched(model, shape, phase):
    """A recording of the model's own steps, under sines from a step `phase` on."""
    held = 4 if shape == "each fourth" else 1
    motion = Motion(model, controls=lambda _, step: sines(model, phase + step // held))
    rows = {"from the middle": slice(30, None), "each fourth": slice(None, None, 4)}
    arrays = motion.arrays(rows.get(shape, slice(None)), warm=shape == "warm")
    if shape == "6 digits":
        digits = np.vectorize(lambda value: float(f"{value:.6g}"), otypes=[float])
        arrays = {
            part: digits(arrays[part]) if part != "time" else arrays[part] for part in arrays
        }
    return arrays


@pytest.mark.long
@pytest.mark.parametrize("name", ROBOTS, ids=named)
def test_further_recordings_as_they_are_have_no_finding(name):
    """These and the recordings above are a hundred recordings of six robots."""
    model = compiled(name)
    for phase in (50, 100, 150):
        for shape in ("as it is", "warm", "from the middle", "each fourth"):
            assert not checked(model, untouched(model, shape, phase)).findings, (phase, shape)
