"""Every observable of scenes of the capsule in the plane, against smoothed friction and statics."""

from dataclasses import replace

import numpy as np
import pytest

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


@pytest.mark.long
def test_a_millionth_of_friction_is_seen():
    """The tolerance is finer than what a millionth of a parameter does."""
    case = case_of(scene("capsule-turn/0.3"))
    setup, path, end = case.problem.setup, case.problem.motion.path, case.scene.duration
    other = replace(setup, capsule=replace(setup.capsule, friction=0.3 * (1 + 1e-6)))
    change = moved(other, path, end) - moved(setup, path, end)
    assert np.abs(change[:3]).max() > 5 * LEFT
