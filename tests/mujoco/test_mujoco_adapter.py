"""MuJoCo's cone pendulum against the exact motion and another solver: error, order, armature."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.added_inertia import platform_error
from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.stepper import MujocoStepper
from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.engines.adapters.mujoco.trimming import trimming
from plumbob.engines.registry import method as find_method
from plumbob.models.cone_pendulum.model import MODEL, holding_inertia
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.tests.support.cone_scene import DEFAULT, MJCF, SYSTEM, scene

# nothing is controlled here: the methods that differ in a control are left out
METHODS = {
    m.name: m
    for m in ENGINE.methods
    if not {"control_at", "contact", "model"} & m.settings.keys()
}
RK4 = METHODS["mujoco/rk4"]


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("pivot_x", [0.0, 0.2])
@pytest.mark.parametrize("armature", [1e6, 1e8, 1e10])
def test_armature_has_the_error_that_theory_gives_it(armature, pivot_x):
    # second order in 1/A, and 5e-13 of round-off and step error beside an error of 1.6/A
    problem = replace(DEFAULT, pivot_x=pivot_x)
    simulation = compiled(SYSTEM.case(scene(pivot_x=pivot_x)), RK4, 5e-5)
    firm = simulation.run().observables["theta"]
    spec = filled(MJCF, MODEL, problem)
    spec.joint("platform").armature = armature
    model = spec.compile()
    model.opt.timestep = 5e-5
    simulation.stepper = MujocoStepper(model)
    moved = np.abs(simulation.run().observables["theta"] - firm).max()
    assert moved == pytest.approx(
        platform_error(problem, 0.5, armature)[0], rel=1e-3, abs=5e-13
    )


@pytest.mark.parametrize("pivot", [(20.0, 0.0), (0.0, 20.0), (-15.0, 15.0)])
def test_armature_exceeds_the_load_wherever_the_pivot_is(pivot):
    x, y = pivot
    problem = replace(DEFAULT, pivot_x=x, pivot_y=y)
    carried = DEFAULT.body.mass * (x**2 + y**2)  # and the body's own, which is less
    assert 1e15 * carried < holding_inertia(problem) < 2e16 * carried


@pytest.mark.parametrize(
    "case",
    [
        SYSTEM.case(scene()),
        *map(case_of, map(find_scene, ("capsule-line/ca1", "capsule-hold/0.9", "pinch/0.5"))),
    ],
    ids=lambda case: case.scene.name,
)
def test_trimming_changes_no_bit(case):
    # 0.1 s of each is enough
    contacts = ("mujoco/euler+coulomb", "mujoco/euler+reduced", "mujoco/euler")
    methods = METHODS.values() if case.system is SYSTEM else map(find_method, contacts)
    for method in methods:
        if method.surrogate and case.system.name == "pinch":
            continue  # a model of the capsule alone
        assert trimming(case, method, 1e-4, steps=500, repeats=2).identical
