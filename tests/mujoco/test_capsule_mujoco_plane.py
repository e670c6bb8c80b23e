"""MuJoCo's capsule in the plane: turns, spin and a plan against the exact motion."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.mujoco_capsule import LOADS, METHODS, run

EULER, RK4 = "euler+coulomb", "rk4+coulomb"


@pytest.mark.parametrize("heading", [3.0, -3.0])
def test_a_heading_goes_on_where_its_angle_jumps(heading):
    # turns by 0.52 rad, through half a turn
    rate = 6.0 if heading > 0.0 else -6.0
    turned = scene("capsule-coast/rotation", {"heading": heading, "heading_rate": rate})
    found, _ = measure(case_of(turned), METHODS[EULER], 1e-3)
    assert abs(found.errors["heading"].end) < 0.01


def test_implicitfast_takes_another_step_with_a_lone_body():
    # velocity derivatives of a free body's centripetal forces, which it drops in a tree
    other = replace(
        METHODS["implicitfast+coulomb"],
        settings={
            **METHODS["implicitfast+coulomb"].settings,
            "integrator": "implicit",
        },
    )
    case = scene("capsule-coast/spin")
    found = compiled(case_of(case), other, 1e-3).run().observables["x"]
    same = run("capsule-coast/spin", "implicitfast+coulomb", 1e-3)[1].observables["x"]
    np.testing.assert_allclose(found, same, rtol=0, atol=1e-14)
    lone = run("capsule-coast/spin", "implicitfast+coulomb", 1e-3)[0]
    assert all(error.predicted is None for error in lone.errors.values())
    assert "no error theory" in lone.note


@pytest.mark.parametrize("case", ["ca1", "frictionless"])
@pytest.mark.parametrize("method", ["mujoco/euler", "mujoco/euler+elliptic", "mujoco/rk4+coulomb"])
def test_forces_of_contacts_are_those_that_the_engine_tells(method, case):
    """The slider's drive shows in the balance of momentum (test_capsule_mujoco)."""
    simulation = compiled(case_of(scene(f"capsule-line/{case}")), find_method(method), 1e-3)
    model, data, force = simulation.model, simulation.data, np.empty(6)
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_SENSOR)
    data.ctrl[:] = 0.1
    mujoco.mj_step(model, data, nstep=40)
    mujoco.mj_forward(model, data)
    loads, drag = np.zeros(3), np.zeros(3)
    for i, contact in enumerate(data.contact):
        mujoco.mj_contactForce(model, data, i, force)
        loads[max(contact.geom) - model.geom("support_1").id] += force[0]
        drag += force[1:3] @ contact.frame[3:].reshape(2, 3)
    assert simulation.translation.sensors is not None
    read, channels = simulation.translation.sensors(np.array([data.sensordata]))
    assert [*loads] == [read[load][0] for load in LOADS]
    assert channels["contacts"] == data.ncon
    assert read["friction_force"] == pytest.approx(drag[0], rel=1e-14, abs=1e-300)
    assert loads.min() > 0.0
    assert abs(drag[0]) > 0.0 or case == "frictionless"
