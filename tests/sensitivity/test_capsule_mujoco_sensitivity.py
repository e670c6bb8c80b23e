"""MuJoCo's capsule: small mistakes are detected, bounds are not loose, random bodies pass."""

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.cases import beyond
from plumbob.tests.support.mujoco_capsule import (
    LOADS,
    METHODS,
    REDUCED,
    run,
)


def tight(found, name):
    """Model-error bound over the unpredicted part of the error."""
    return sum(found.errors[name].model.values()) / beyond(found.errors[name])


@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_bounds_are_not_loose(step):
    # within their allowance for phases and for oscillations of an underdamped contact
    found, _ = run("capsule-line/at-123", "euler+coulomb", step)
    for name in ("displacement", "velocity", "heading", "friction_force", *LOADS):
        assert 1.0 <= tight(found, name) < 15.0, name
    assert 1.0 <= tight(found, "stroke") < 1.5


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("method", REDUCED)
@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("capsule-line/ca1", 1e-3),
        ("capsule-line/ca1", 1e-5),
        ("capsule-line/light-slider", 5e-7),
        ("capsule-coast/translation", 1e-3),
        ("capsule-hold/0.999", 1e-4),
        ("capsule-hold/slow-motion", 1e-4),
        ("capsule-train/ten", 1e-3),
    ],
)
def test_bounds_of_the_reduced_model_are_within_a_factor_of_30(name, step, method):
    for observable, error in run(name, method, step)[0].errors.items():
        if error.scale:  # what stays zero is exact
            bound = sum(error.model.values())
            assert beyond(error) <= bound <= 30 * beyond(error), observable


def test_a_solver_that_stops_early_exceeds_the_bounds_of_the_reduced_model():
    case = case_of(scene("capsule-line/ca1"))
    method = METHODS["euler+reduced"]
    simulation = compiled(case, method, 1e-3)
    assert simulation.model.opt.solver == mujoco.mjtSolver.mjSOL_PGS
    simulation.model.opt.iterations = 0
    off = (
        simulation.run().observables["displacement"]
        - compiled(case, method, 1e-3).run().observables["displacement"]
    )
    bound = sum(ENGINE.model_error(case, method, 1e-3)["displacement"].values())
    assert np.abs(off).max() > bound
