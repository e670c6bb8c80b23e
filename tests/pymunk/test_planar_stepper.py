"""The planar builder of pymunk: states, steps and forces of any mechanism of the plane."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.pymunk.stepper import planar_stepper
from plumbob.engines.stepper import State, TellsForces
from plumbob.models.registry import case_of, find_system, scene
from plumbob.tests.support.planar import (
    TIGHT,
    mechanism_of,
    method_for,
    scene_mechanism,
    stepper_of,
)

SYSTEMS = (
    *("bouncing-ball", "cone-pendulum", "four-bar", "incline", "linear-pendulum", "n-pendulum"),
    *("pinch", "projectile", "rod-impact", "rolling-ball", "servo", "simple-pendulum"),
    *("slider-crank", "stack"),
)
SCENES = [
    *(
        f"{name}/{find_system(name).default}".replace("to-rest", "slide-to-roll")
        for name in SYSTEMS
    ),
    *("simple-pendulum/forced-large", "servo/saturated-swings", "pinch/pushed"),
]
ROUNDED = 1e-13  # of coordinates of order 1, which pass a rotation and its inverse
# A cart on a rail with a rod on it, and another rod on that: a spring between the rods, and dampers
# and a motor, all of which a chain of bare rods does not have.
CART = """
<mujoco><compiler angle="radian" autolimits="true"/>
  <option timestep="1e-4" integrator="RK4"/>
  <worldbody><body name="cart"><joint name="rail" type="slide" axis="1 0 0" damping="0.4"/>
    <inertial pos="0 0 0" mass="1.5" diaginertia="1 1 1"/>
    <body name="rod"><joint name="hip" axis="0 1 0" damping="0.05"/>
      <inertial pos="0 0 -0.3" mass="0.7" diaginertia="0.03 0.03 0.03"/>
      <body name="tip" pos="0 0 -0.6"><joint name="knee" axis="0 -1 0" stiffness="3" springref="0.4"
        damping="0.02"/><inertial pos="0.1 0 -0.1" mass="0.4" diaginertia="0.01 0.01 0.01"/>
  </body></body></body></worldbody>
  <actuator><motor joint="knee" gear="0.5"/><position joint="rail" kp="8" kv="1" forcerange="-3 3"/>
  </actuator>
  <keyframe><key qpos="0.1 0.6 -0.3" qvel="0.2 -1 2"/></keyframe>
</mujoco>"""
# Two boxes on a floor that touch each other: no three factors have these coefficients as products.
RUBBING = """
<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
  <body name="left" pos="-0.1 0 0.1"><joint type="slide" axis="1 0 0"/><joint type="slide"
    axis="0 0 1"/><geom name="left" type="box" size="0.1 0.1 0.1" mass="1"/></body>
  <body name="right" pos="0.1 0 0.1"><joint type="slide" axis="1 0 0"/><joint type="slide"
    axis="0 0 1"/><geom name="right" type="box" size="0.1 0.1 0.1" mass="1"/></body></worldbody>
  <contact><pair geom1="left" geom2="right" friction="0.9 0.9"/>
    <pair geom1="floor" geom2="left" friction="0.2 0.2"/>
    <pair geom1="floor" geom2="right" friction="0.4 0.4"/></contact>
  <keyframe><key qpos="0 0 0 0" qvel="-1 0 1 0"/></keyframe></mujoco>"""


def controls_of(name, step, steps):
    """The controls of a scene at the begin of its steps, or None."""
    controls = scene_mechanism(name).controls
    return None if controls is None else controls(step * np.arange(steps))


@pytest.mark.parametrize("name", SCENES)
def test_nothing_survives_a_put(name):
    step, steps = 2e-3, 40
    used = stepper_of(name, step)
    controls = controls_of(name, step, steps)
    used.advance(controls, steps)
    middle = used.state()
    used.advance(controls, steps)
    used.put(middle)
    fresh = stepper_of(name, step)
    fresh.put(middle)
    for stepper in (used, fresh):
        stepper.advance(controls, steps)
    assert used.state().qpos.tobytes() == fresh.state().qpos.tobytes()
    assert used.state().qvel.tobytes() == fresh.state().qvel.tobytes()
    assert (
        used.forces_of_last_step().joints.tobytes()
        == fresh.forces_of_last_step().joints.tobytes()
    )
    assert (
        used.forces_of_last_step().touching.tobytes()
        == fresh.forces_of_last_step().touching.tobytes()
    )


@pytest.mark.parametrize("name", SCENES)
def test_a_state_is_read_as_it_was_put(name):
    stepper = stepper_of(name, 1e-3)
    start = scene_mechanism(name).start
    assert stepper.state().qpos == pytest.approx(start.qpos, abs=ROUNDED)
    assert stepper.state().qvel == pytest.approx(start.qvel, abs=ROUNDED)


def test_any_state_of_a_tree_is_read_as_it_was_put():
    mechanism, model, start = mechanism_of(CART)
    stepper = planar_stepper(mechanism, start, TIGHT, 1e-3)
    rng = np.random.default_rng(0)
    for _ in range(10):
        state = State(rng.normal(size=model.nq), rng.normal(size=model.nv))
        stepper.put(state)
        assert stepper.state().qpos == pytest.approx(state.qpos, abs=ROUNDED)
        assert stepper.state().qvel == pytest.approx(state.qvel, abs=ROUNDED)


def test_slides_out_of_the_plane_keep_their_place():
    stepper = stepper_of("incline/stops", 1e-3)
    for aside in (0.3, -0.2):
        stepper.put(State(np.array([0.1, aside, 0.0]), np.array([1.0, 0.0, 0.0])))
        stepper.advance(None, 10)
        assert stepper.state().qpos[1] == pytest.approx(aside, abs=ROUNDED)


def test_springs_dampers_and_actuators_of_a_tree_move_it_as_in_mujoco():
    mechanism, model, start = mechanism_of(CART)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    control = [0.7, 0.5]
    data.ctrl[:] = control
    mujoco.mj_step(model, data, 5000)
    errors = []
    for step in (1e-3, 2.5e-4):
        stepper = planar_stepper(mechanism, start, TIGHT, step)
        stepper.put(start)
        steps = round(0.5 / step)
        stepper.advance(np.tile(control, (steps, 1)), steps)
        errors.append(np.abs(stepper.state().qpos - data.qpos).max())
    # of first order: a quarter of the step leaves a quarter of the error, within a tenth
    assert errors[0] < 5e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def turned(mechanism, angle):
    """A mechanism turned about the vertical by an angle [rad]."""
    half = np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])

    def rotated(place):
        result = np.zeros(3)
        mujoco.mju_rotVecQuat(result, place, half)
        return result

    def attitude(own):
        result = np.zeros(4)
        mujoco.mju_mulQuat(result, half, own)
        return result

    world = [
        b
        if b.parent or i == 0
        else replace(b, place=rotated(b.place), attitude=attitude(b.attitude))
        for i, b in enumerate(mechanism.bodies)
    ]
    loops = [
        replace(
            loop,
            places=tuple(
                p if body else rotated(p)
                for body, p in zip(loop.bodies, loop.places, strict=True)
            ),
        )
        for loop in mechanism.loops
    ]
    return replace(mechanism, bodies=tuple(world), loops=tuple(loops))


@pytest.mark.parametrize(
    "name",
    [
        "slider-crank/turning",
        "four-bar/crank-rocker",
        "rod-impact/sticks",
        "rolling-ball/backspin",
    ],
)
def test_the_plane_may_be_any(name):
    found = scene_mechanism(name)
    ends = []
    for mechanism in (found.mechanism, turned(found.mechanism, 0.7)):
        stepper = planar_stepper(mechanism, found.start, method_for(name), 1e-3)
        stepper.put(found.start)
        stepper.advance(None, 150)
        ends.append(stepper.state().qpos)
    # rounding alone, which joints and impacts multiply by some thousand
    assert ends[1] == pytest.approx(ends[0], abs=1e-11)


def test_each_pair_has_its_own_friction():
    mechanism, _, start = mechanism_of(RUBBING)
    stepper = planar_stepper(mechanism, start, method_for("incline/stops"), 1e-3)
    stepper.put(start)
    stepper.advance(None, 200)
    gravity = 9.81
    assert stepper.state().qvel[[0, 2]] == pytest.approx(
        [-1.0 + 0.2 * gravity * 0.2, 1.0 - 0.4 * gravity * 0.2], abs=1e-9
    )


def test_joints_of_hanging_rods_carry_what_is_below_them():
    mechanism = scene_mechanism("n-pendulum/triple").mechanism
    rest = State(np.zeros(3), np.zeros(3))
    stepper = planar_stepper(mechanism, rest, TIGHT, 1e-3)
    stepper.put(rest)
    assert isinstance(stepper, TellsForces)
    assert np.isnan(stepper.forces_of_last_step().joints).all()
    stepper.advance(None, 20)
    masses = [body.mass for body in mechanism.bodies[1:]]
    weights = 9.81 * np.cumsum(masses[::-1])[::-1]
    expected = np.stack([0 * weights, 0 * weights, weights], axis=1)
    assert stepper.forces_of_last_step().joints == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_cubes_of_a_stack_push_up_what_they_carry():
    name = "stack/heavy-top-100"
    stepper = stepper_of(name, 1e-3)
    stepper.advance(None, 20)
    stack = case_of(scene(name)).problem
    touching = scene_mechanism(name).mechanism.touching
    pushed = {
        t.shapes: f
        for t, f in zip(touching, stepper.forces_of_last_step().touching, strict=True)
    }
    for lower, force in enumerate(stack.normal_forces):
        assert pushed[lower, lower + 1] == pytest.approx([0.0, 0.0, force], rel=1e-9, abs=1e-9)


def test_fingers_press_and_hold_a_load_together():
    name = "pinch/pushed"
    stepper = stepper_of(name, 1e-3)
    stepper.advance(controls_of(name, 1e-3, 20), 20)
    pinch = case_of(scene(name)).problem
    mechanism = scene_mechanism(name).mechanism
    names = [shape.name for shape in mechanism.shapes]
    on_cube = {}
    for touch, force in zip(
        mechanism.touching, stepper.forces_of_last_step().touching, strict=True
    ):
        first, second = (names[number] for number in touch.shapes)
        if first == "cube":
            on_cube[second] = -force
    assert on_cube["left"][1] == pytest.approx(pinch.normal_force, rel=1e-6)
    assert on_cube["right"][1] == pytest.approx(-pinch.normal_force, rel=1e-6)
    weight = pinch.mass * mechanism.gravity
    assert sum(on_cube.values()) == pytest.approx(-weight, abs=1e-6)


def test_a_joint_in_a_loop_tells_no_force():
    stepper = stepper_of("four-bar/crank-rocker", 1e-3)
    stepper.advance(None, 5)
    assert np.isnan(stepper.forces_of_last_step().joints).all()


def test_a_platform_keeps_its_rate():
    stepper = stepper_of("cone-pendulum/rotating-base", 1e-3)
    start = scene_mechanism("cone-pendulum/rotating-base").start
    stepper.advance(None, 100)
    assert stepper.state().qpos[0] == pytest.approx(0.1 * start.qvel[0])
    assert stepper.state().qvel[0] == start.qvel[0]
