"""The capsule's MJCF files: their literal numbers, their motion outside the package, what the
adapter builds from them, and their scenes."""

import itertools
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob.analytic.errors.sliding_motion.sliding_errors import step_error
from plumbob.engines.adapters.mujoco.options import collected
from plumbob.models.tripod_capsule.model import (
    ARMATURE_RATIO,
)
from plumbob.tests.support.fixed_step import mean_acceleration
from plumbob.tests.support.random_capsules import CHECK, LINE

FOLDER = Path(__file__).parents[2] / "models" / "tripod_capsule"
FULL, REDUCED = (FOLDER / f"{name}.xml" for name in ("tripod_capsule", "reduced"))
STEP = 1e-4  # that the files are written for


def load(file):
    """The file as it stands."""
    return mujoco.MjModel.from_xml_path(str(file))


SUPPORTS = [f"support_{i}{axis}" for i in range(3) for axis in "xy"]


def numbers(model):
    """The numbers of the source's problem that a full model has."""
    body = model.body("body")
    slider = model.body("slider")
    places = [float(x) for i in (1, 2, 3) for x in model.geom(f"support_{i}").pos[:2]]
    return {
        "body_mass": body.mass[0],
        "slider_mass": slider.mass[0],
        "inertia": body.inertia[2],
        "gravity": -model.opt.gravity[2],
        "friction": model.pair_friction[0, 0],
        **dict(zip(SUPPORTS, places, strict=True)),
    }


def wanted():
    """The same for the check values of physics.md."""
    names = ("body_mass", "slider_mass", "inertia", "gravity", "friction")
    places = dict(zip(SUPPORTS, itertools.chain(*CHECK.supports), strict=True))
    return {**{name: getattr(CHECK, name) for name in names}, **places}


def test_numbers_are_the_check_values():
    model = load(FULL)
    assert numbers(model) == wanted()
    assert (model.pair_friction[:, :2] == CHECK.friction).all()
    for i in (1, 2, 3):  # their lowest points at height zero, with C and the slider
        support = model.geom(f"support_{i}")
        assert support.pos[2] == support.size[0] <= 1e-5
    np.testing.assert_array_equal(model.body("body").ipos, 0.0)
    np.testing.assert_array_equal(model.body("slider").pos, 0.0)
    assert model.jnt_type[model.joint("slider").id] == mujoco.mjtJoint.mjJNT_SLIDE
    assert (
        model.dof_armature[-1]
        == model.actuator_gear[0, 0]
        >= ARMATURE_RATIO * CHECK.slider_mass
    )


def test_the_reduced_model_has_the_same_numbers():
    reduced = load(REDUCED)
    assert reduced.dof_frictionloss[0] == pytest.approx(
        CHECK.friction * CHECK.weight, rel=1e-15
    )
    assert [reduced.body(b).mass[0] for b in ("body", "slider")] == [1.0, 0.3]


def displacement(file):
    """How far the body goes [m] in the file as it stands, driven by the check manoeuvre."""
    model = load(file)
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    with collected():  # a message of its line search is no error of the motion
        _drive(model, data)
    assert not any(warning.number for warning in data.warning)
    return float(data.qpos[0])


def _drive(model, data):
    for w in mean_acceleration(LINE, np.arange(1501, dtype=np.float64) * STEP):
        data.ctrl[0] = w
        mujoco.mj_step(model, data)


@pytest.mark.parametrize(
    ("name", "bound"),
    [
        # what static penetration and the drift of regularised stiction add with S = 1, 6.0e-8
        # relative; and friction loss at an impedance of 0.9999, whose drift subtracts 3.3e-7
        ("tripod_capsule", 1e-7),
        ("scene", 1e-7),
        ("reduced", 5e-7),
    ],
)
def test_a_file_as_it_stands_takes_the_step_that_theory_says(name, bound):
    exact = LINE.displacement
    error = displacement(FOLDER / f"{name}.xml") - exact
    assert error == pytest.approx(float(step_error(LINE, STEP)), abs=bound * abs(exact))
