"""Every observable of scenes of the capsule in the plane, against smoothed friction and statics."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres.residual_motion import coasting
from plumbob.analytic.systems.slider_path import SliderPath, StraightPiece
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.smoothed_friction import followed, smoothed_pose

POSE = ("x", "y", "heading")
RATES = ("velocity_x", "velocity_y", "heading_rate")
# What smoothing leaves after its extrapolation, of a pose of 1 m or rad, and of rates while
# supports slip, of 1 m/s or rad/s and more; where a load grows through the friction limit it goes
# as delta^(4/5).
LEFT = 2e-9
LEFT_RATE = 2e-7
GRADUAL = 3e-8

SCENES = {  # the first ones take least
    "capsule-coast/spin": (0.3, LEFT),
    "capsule-turn/0.3": (0.4, LEFT),
    "capsule-plan/beside-curve-23-longer": (0.27, LEFT),
    "capsule-coast/rotation": (0.6, LEFT),
    "capsule-coast/translation": (0.6, LEFT),
    "capsule-turn/heading-030": (0.3, LEFT),
    "capsule-turn/unloaded-short": (0.5, GRADUAL),
    "capsule-turn/pivot-short": (0.4, GRADUAL),
    "capsule-turn/held-short": (0.8, GRADUAL),
    "capsule-plan/near-free": (0.27, LEFT),
}
"""A part of the duration, while supports slip, and what smoothing leaves of a pose."""


def loads(capsule, slider):
    """N_i by the balance of forces, and of moments about C [N]."""
    weight = capsule.slider_mass * capsule.gravity
    total = weight + capsule.body_mass * capsule.gravity
    balance = np.vstack([np.ones(3), np.transpose(capsule.supports)])
    return np.linalg.solve(balance, [total, weight * slider[0], weight * slider[1]])


def place(path, time):
    """The slider's place in the body at a `time` [s], by the numbers of its path's pieces."""
    for piece in path.pieces:
        if time <= piece.duration:
            return followed(piece, time)[0]
        time -= piece.duration
    return followed(piece, piece.duration)[0]


def moved(setup, path, time):
    """Pose and rates at a `time` [s], in the world's axes of the start."""
    start = (0.0, 0.0, 0.0, *setup.velocity, setup.heading_rate)
    found = smoothed_pose(setup.capsule, path, start, time)
    return np.concatenate([found.pose, found.rates])


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("name", SCENES)
def test_every_observable(name):
    part, left = SCENES[name]
    case = case_of(scene(name))
    setup, path = case.problem.setup, case.problem.motion.path
    for time in (part * case.scene.duration, case.scene.duration):
        seen = {n: v[0] for n, v in case.reference.observe(np.array([time])).items()}
        state = moved(setup, path, time)
        state[2] += setup.heading
        found = [seen[n] for n in (*POSE, *RATES)]
        assert np.abs(state - found)[:3].max() < left, (time, state - found)
        assert np.abs(state - found)[3:].max() < max(LEFT_RATE, left), (time, state - found)
        turned = seen.get("body_angle", state[2] - setup.heading)
        assert abs(turned - (state[2] - setup.heading)) < left
        forces = [seen[f"normal_force_{i}"] for i in (1, 2, 3)]
        wanted = loads(setup.capsule, place(path, time))
        np.testing.assert_allclose(forces, wanted, rtol=1e-12)


@pytest.mark.parametrize("name", ["capsule-turn/0.3", "capsule-turn/pivot-short"])
def test_a_turn_is_a_half_forward_and_a_half_back(name):
    """Eq. 29, by the numbers of the scene."""
    p = scene(name).parameters
    tau, z, begin = p["half_time"], p["angular_acceleration"], p["start"]
    path = case_of(scene(name)).problem.motion.path
    for part in (0.3, 1.0, 1.4, 2.0):
        angle = z * tau**2 * (part**2 / 2 - max(part - 1, 0.0) ** 2)
        rate = z * tau * (part - 2 * max(part - 1, 0.0))
        x, y = p["radius"] * np.cos(begin + angle), p["radius"] * np.sin(begin + angle)
        seen, speed, _ = path.kinematics(np.array([part * tau]))
        np.testing.assert_allclose(seen[0], (x, y), rtol=0, atol=1e-15)
        np.testing.assert_allclose(
            speed[0], (-rate * y, rate * x), rtol=0, atol=1e-13 * z * tau
        )


def test_a_turn_about_the_combined_centre():
    """Where that is not C: C goes round it, and the arms that brake are equal."""
    centre = 0.3 / 1.3 * np.array([0.1, 0.05])
    arms = 0.2 * np.array([[1.0, 0.0], [-0.5, 0.75**0.5], [-0.5, -(0.75**0.5)]])
    corners = tuple(tuple(map(float, arm)) for arm in centre + arms)
    capsule = Capsule(1.0, 0.3, 0.02, corners, 0.3, 9.81)
    velocity = 4.0 * centre[1], -4.0 * centre[0]
    motion = coasting(capsule, (0.1, 0.05), velocity, 4.0)
    path = SliderPath((StraightPiece(1.0, (0.1, 0.05), 0.0, 0.0, 0.0, 0.0),))
    for time in (0.03, 0.5):
        seen = {n: v[0] for n, v in motion.observe(np.array([time])).items()}
        found = smoothed_pose(capsule, path, (0, 0, 0, *velocity, 4.0), time)
        assert np.abs(found.pose - [seen[n] for n in POSE]).max() < LEFT
        assert np.abs(found.rates - [seen[n] for n in RATES]).max() < LEFT_RATE


@pytest.mark.long
def test_two_turns_are_one_motion():
    """Whole circles of the slider, the second from where the first has come to rest."""
    case = case_of(scene("capsule-turn/thousand", {"count": 2}))
    setup, motion = case.problem.setup, case.problem.motion
    for time in (1.2 * motion.period, 2.0 * motion.period):
        at = motion.at(np.array([time]))
        state = moved(setup, motion.path, time)
        found = [*at.position[0], *at.heading, *at.velocity[0], *at.angular_velocity]
        assert np.abs(state - found)[:3].max() < 2 * LEFT
        assert np.abs(state - found)[3:].max() < LEFT_RATE


@pytest.mark.long
def test_a_millionth_of_friction_is_seen():
    """The tolerance is finer than what a millionth of a parameter does."""
    case = case_of(scene("capsule-turn/0.3"))
    setup, path, end = case.problem.setup, case.problem.motion.path, case.scene.duration
    other = replace(setup, capsule=replace(setup.capsule, friction=0.3 * (1 + 1e-6)))
    change = moved(other, path, end) - moved(setup, path, end)
    assert np.abs(change[:3]).max() > 5 * LEFT
