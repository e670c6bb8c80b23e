"""MuJoCo's capsule in the plane: turns, spin and a plan against the exact motion."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.analytic.errors.contact_models import soft_contact_plane
from plumbob.analytic.errors.contact_models.soft_contact_plane import missing_loads, plane_motion
from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene, systems
from plumbob.tests.support.mujoco_capsule import LOADS, METHODS, problem, run

TURN = systems()["capsule-turn"]
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


def test_loads_are_exact_where_nothing_deflects():
    posed = problem("capsule-turn/0.3")
    motion, across = plane_motion(posed, 0.1), 0.046
    np.testing.assert_array_equal(missing_loads(posed, motion, 0.0, across), 0.0)
    lost = missing_loads(posed, motion, 1e-7, across)
    np.testing.assert_allclose(missing_loads(posed, motion, 2e-7, across), 2.0 * lost, rtol=1e-9)


@pytest.mark.parametrize(("method", "least", "most"), [(EULER, 0.6, 0.7), (RK4, 0.98, 1.0)])
def test_a_bound_ends_where_the_steps_rest(method, least, most, monkeypatch):
    """Of Euler's steps that is later than the exact motion's rest, of RK4's it is not."""
    case = case_of(scene("capsule-turn/heavy-slider"))
    given = (case, METHODS[method], case.scene.steps[0])
    stepped = sum(ENGINE.model_error(*given)["body_angle"].values())
    monkeypatch.setattr(soft_contact_plane, "_stepping", lambda *given: False)
    assert least < sum(ENGINE.model_error(*given)["body_angle"].values()) / stepped <= most


def test_the_file_turns_by_itself():
    model = mujoco.MjModel.from_xml_path(str(TURN.mjcf.with_name("turning.xml")))
    rebuilt = compiled(case_of(scene("capsule-turn")), METHODS[EULER], 1e-4).model
    for name in (
        "body_mass",
        "body_inertia",
        "body_pos",
        "dof_armature",
        "jnt_axis",
        "pair_friction",
    ):
        np.testing.assert_allclose(getattr(model, name), getattr(rebuilt, name), rtol=1e-12)
    assert measure(case_of(scene("capsule-turn/0.3")), METHODS[RK4], 1e-2)[0].status == "done"


@pytest.mark.parametrize("method", ["euler", "euler+coulomb"])
def test_where_a_body_rests_is_kept_for_one_model_alone(method):
    """Contacts of `coulomb` are stiffer at a smaller step; MuJoCo's own are the same at each."""
    case = case_of(scene("capsule-turn/0.3"))
    heights = [float(compiled(case, METHODS[method], h).translation.qpos[2]) for h in (1e-3, 5e-4)]
    heavier = case_of(scene("capsule-turn/0.3", {"gravity": 12.0}))
    lower = float(compiled(heavier, METHODS[method], 1e-3).translation.qpos[2])
    assert (heights[0] == heights[1]) == (method == "euler")
    assert lower < heights[0] < 0.0


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
