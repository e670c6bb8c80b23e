"""Parts of mechanisms in Exudyn: balls, free bodies, prescribed joints, loops and contacts."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.compiled_mechanism import compiled_mechanism
from plumbob.engines.method import Unsupported
from plumbob.engines.registry import method as find_method
from plumbob.engines.stepper import State
from plumbob.engines.study.measurement import measure, relative_error
from plumbob.tests.peers.test_dart_mechanisms import case, default, scene_mechanism
from plumbob.tests.peers.test_mechanisms import LOOPS, STEP, exudyn
from plumbob.tests.peers.test_smooth_peers import needed
from plumbob.tests.support.built_mechanisms import stepped
from plumbob.tests.support.cases import error_of_run

DEFAULT = "exudyn/default"


def test_exudyn_s_explicit_solvers_refuse_what_they_would_ignore():
    needed("exudyn/rk44")
    for name, feature in (
        ("four-bar/crank-rocker", "loop pin"),
        ("incline/rest", "contacts"),
        ("capsule-line/heading-030", "changing velocity of joint slider"),
    ):
        with pytest.raises(Unsupported, match=feature):
            exudyn(scene_mechanism(name).mechanism, None, "exudyn/rk44")


TURNS_AND_CARRIES = """<mujoco><option integrator="RK4" timestep="1e-3"/><worldbody>
  <body pos="0 0 1" quat="1 0.2 0.1 0.3"><freejoint/>
    <inertial pos="0.1 0 0.05" mass="2" fullinertia="0.3 0.2 0.25 0.01 0.02 0.03"/>
    <body pos="0.1 0 0"><inertial pos="0 0 0.1" mass="0.5" diaginertia="0.01 0.02 0.02"/>
      <body pos="0.2 0 0" quat="1 0 0.2 0"><joint type="ball" pos="0 0.1 0"/>
        <inertial pos="0.1 0.1 0" mass="1" diaginertia="0.1 0.2 0.15"/></body>
    </body>
  </body>
  <body pos="3 0 1"><freejoint/>
    <inertial pos="0.1 0 0.05" mass="2" fullinertia="0.3 0.2 0.25 0.01 0.02 0.03"/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize("solver", ["exudyn/default", "exudyn/rk44"])
def test_exudyn_s_free_bodies_and_balls_move_as_mujoco_s(solver):
    """A free body that carries a ball, as hinges in Exudyn, by a body welded to it, and one free
    body by itself."""
    needed(solver)
    model = mujoco.MjModel.from_xml_string(TURNS_AND_CARRIES)
    data = mujoco.MjData(model)
    data.qvel[:] = np.random.default_rng(0).normal(size=model.nv)
    made = exudyn(compiled_mechanism(model), None, solver)
    made.put(State(data.qpos.copy(), data.qvel.copy()))
    made.advance(None, 200)
    mujoco.mj_step(model, data, 200)
    # MuJoCo's own error, of which the turns have order 2, and the default solver's, of order 2.
    np.testing.assert_allclose(made.state().qpos, data.qpos, atol=1e-5)
    np.testing.assert_allclose(made.state().qvel, data.qvel, atol=1e-4)


def test_exudyn_prescribes_a_changing_velocity():
    """A platform at the rate 2 + sin 3t, put where it is at 0.5 s and off the grid of steps."""
    needed("exudyn/default")
    parts = scene_mechanism("cone-pendulum/rotating-base")
    platform, hinge = parts.mechanism.joints
    moving = replace(platform, velocity=lambda times: 2.0 + np.sin(3.0 * times))
    for begin in (0.5, 0.50037):
        made = exudyn(replace(parts.mechanism, joints=(moving, hinge)), None)
        made.put(State(parts.start.qpos, np.array([2.0 + np.sin(3.0 * begin), 0.0])), begin)
        made.advance(None, 200)
        # Newton's method solves the constraint to 1e-8 of what it was wrong by.
        rate = 2.0 + np.sin(3.0 * (begin + 0.2))
        assert made.state().qvel[0] == pytest.approx(rate, abs=1e-9)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", LOOPS)
def test_exudyn_s_loops_stay_closed_and_have_order_2(name):
    needed("exudyn/default")
    scene, how = case(default(name)), find_method("exudyn/default")
    quantities = scene.system.quantities(scene)
    coarse, fine = (
        relative_error(measure(scene, how, step)[0], quantities) for step in (1e-3, 5e-4)
    )
    assert fine < 1e-3
    assert coarse / fine == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("slip", [2.5, 5.0])
def test_exudyn_s_body_that_should_stick_drifts_at_a_part_of_the_slip_speed(slip, monkeypatch):
    """Friction is in proportion to a slip below `slip` times the step: at 0.9 of the slope that
    friction holds a cube slips at 0.9 of that."""
    needed("exudyn/default")
    from plumbob.engines.adapters.exudyn import contacts

    monkeypatch.setattr(contacts, "SLIP", slip)
    parts = scene_mechanism("incline/rest")
    made = exudyn(parts.mechanism, None)
    made.put(parts.start)
    # 50 ms are long enough for the fall of the first steps to be over.
    assert stepped(made, parts, 50).qvel[0] == pytest.approx(0.9 * slip * STEP, rel=1e-3)


@pytest.mark.parametrize(("steps", "wanted"), [(20.0, 0.4972), (60.0, 0.4998)])
def test_exudyn_s_ball_bounces_back_more_exactly_the_more_steps_it_takes(
    steps, wanted, monkeypatch
):
    needed("exudyn/default")
    from plumbob.engines.adapters.exudyn import contacts

    monkeypatch.setattr(contacts, "BOUNCE", steps)
    mechanism = replace(scene_mechanism("bouncing-ball/half").mechanism, gravity=np.zeros(3))
    made = exudyn(mechanism, None)
    made.put(State(np.array([0.1005]), np.array([-1.0])))
    made.advance(None, 200)
    assert made.state().qvel[0] == pytest.approx(wanted, abs=1e-4)


def test_exudyn_s_error_of_a_turn_is_in_proportion_to_the_speeds_of_regularised_friction(
    monkeypatch,
):
    """A body that turns back passes speeds in which friction is in proportion to the slip. If that
    lasts several steps, the error is in proportion to these speeds; by default it lasts less than
    a step, and the error depends on where in a step the body turns, too."""
    needed(DEFAULT)
    from plumbob.engines.adapters.exudyn import contacts

    usual = contacts.SLIP

    def error(slip, step):
        monkeypatch.setattr(contacts, "SLIP", slip)
        return error_of_run("incline/returns", DEFAULT, step)

    wide, wider, coarse = error(20.0, STEP), error(40.0, STEP), error(40.0, 2.0 * STEP)
    assert wider / wide == pytest.approx(2.0, rel=0.05)
    assert coarse / wider == pytest.approx(2.0, rel=0.05)
    steps = (8e-4, 1e-3, 1.26e-3)  # [s]
    slopes = [error(usual, step) / step for step in steps]
    assert max(slopes) / min(slopes) > 1.2


@pytest.mark.parametrize(
    ("step", "rocker", "tolerance", "ends"),
    [
        (1.5e-3, 0.2002, 1e-8, False),
        (1.5e-3, 0.2002, 1e-6, True),
        (2e-3, 0.2002, 1e-6, False),
        (2e-3, 0.2005, 1e-8, True),
    ],
)
def test_exudyn_s_newton_method_fails_as_a_loop_comes_near_to_its_singular_pose(
    step, rocker, tolerance, ends
):
    """Where links are almost on one line, rounding keeps Newton's method from its tolerance of
    1e-8: a tolerance of 1e-6 lets it end at larger steps, and a longer rocker at any."""
    needed(DEFAULT)
    changes = {"rocker": rocker}
    error = error_of_run(
        "four-bar/near-change-point", DEFAULT, step, None, changes, relativeTolerance=tolerance
    )
    assert math.isfinite(error) == ends
