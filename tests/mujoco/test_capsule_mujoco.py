"""MuJoCo's capsule against the closed forms: displacement, isotropy, holding, loads, momentum."""

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.contacts import soft_contact
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.cases import beyond
from plumbob.tests.support.mujoco_capsule import (
    DEFAULT_SETTINGS,
    GOOD,
    LOADS,
    METHODS,
    REDUCED,
    loads,
    run,
    verdict,
)


@pytest.mark.parametrize(
    "name",
    [
        "capsule-line/at-123",
        "capsule-turn/0.3",
        "capsule-turn/heavy-slider",
        "capsule-coast/edge",
    ],
)
@pytest.mark.parametrize("method", ["euler+coulomb", "rk4+coulomb"])
def test_the_record_for_theory_says_how_far_contacts_deflect(name, method):
    """Wherever the slider is, and however heavy; a run begins with the loads of statics, also with
    a support that carries a three-hundredth of the weight."""
    case = case_of(scene(name))
    step = 1e-4
    exact = case.reference.observe(np.zeros(1))
    contact = soft_contact(case.problem, METHODS[method].settings, step)
    simulation = compiled(case, METHODS[method], step)
    model = simulation.model
    data = mujoco.MjData(simulation.model)
    force = np.zeros(6)
    data.qpos[:] = simulation.translation.qpos
    mujoco.mj_forward(model, data)
    for i in range(3):
        mujoco.mj_contactForce(model, data, i, force)
        wanted = -contact.normal.compliance * force[0]
        assert data.contact[i].dist == pytest.approx(wanted, rel=1e-9)
        assert force[0] == pytest.approx(exact[LOADS[i]][0], rel=1e-6)


@pytest.mark.parametrize(
    ("method", "bar"),
    [
        ("euler+coulomb", 1.2e-7),
        ("rk4+coulomb", 1.2e-7),
        ("euler+reduced", 1e-8),
        ("euler+coulomb+noslip", 1e-12),
    ],
)
def test_holding_at_0999_of_the_threshold(method, bar):
    # a drift of 1e-5 dt F/(3 (M + m)), none with noslip; required: 1e-6 and 1e-9 m in 10 s
    found, held = run("capsule-hold/0.999", method, 1e-3)
    assert np.abs(held.observables["displacement"]).max() < bar
    assert verdict(found, method) == "predicted"


def test_loads_at_rest_are_those_of_statics():
    # At rest accurate to the solver's accuracy; while slip and slider accelerate, to 6e-7 at first,
    # then up to the effect of half a step of slider travel, which is predicted, and of inertia,
    # which is of second order.
    for name in ("capsule-line/at-123", "capsule-line/off-centroid"):
        found, exact, predicted = loads(name, "euler+coulomb", 1e-4)
        relative = np.abs(found / exact - 1.0)
        assert relative[:, -1].max() < 1e-9
        assert relative[:, 0].max() < 1e-6
        assert 1e-5 < relative.max() < 3e-4
        assert np.abs((found - predicted) / exact - 1.0).max() < 1e-5


@pytest.mark.parametrize("method", [*DEFAULT_SETTINGS, *GOOD, *REDUCED])
def test_without_friction_the_centre_of_mass_stays(method):
    # the actuator is internal; required: 1e-12 m
    _, free = run("capsule-line/frictionless", method, 1e-3)
    shift = free.observables["displacement"] + 0.3 / 1.3 * free.observables["stroke"]
    moved = np.ptp(free.channels.get("centre_of_mass", shift))
    assert moved < (1e-15 if method in REDUCED else 1e-12)


def test_what_contacts_add_to_ten_manoeuvres_is_ten_times_what_they_add_to_one():
    one, ten = (
        run(name, "euler+coulomb", 1e-3)[0].errors["displacement"]
        for name in ("capsule-line/ca1", "capsule-train/ten")
    )
    assert beyond(ten) == pytest.approx(10 * beyond(one), rel=0.05)
    name = "contact deflection"
    assert ten.model[name] == pytest.approx(10 * one.model[name], rel=1e-3)
