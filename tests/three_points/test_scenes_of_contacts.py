"""Scenes that tell contact models apart: their exact answers against an independent integration, or
against the same scene in other axes."""

import numpy as np
import pytest

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.models.registry import case_of, scene

ROUND = 1e-13  # of places, angles and their rates: sums of some hundred terms of order 1


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("angle", [30, 45])
@pytest.mark.parametrize(("system", "usual"), [("turn", "0.3"), ("plan", "")])
def test_a_heading_at_the_start_changes_itself_alone(system, usual, angle):
    turned = case_of(scene(f"capsule-{system}/heading-{angle:03d}"))
    straight = case_of(
        scene(f"capsule-turn/{usual}")
        if usual
        else scene(
            "capsule-plan/heading-030", {"start": (0.0, 0.0, 0.0), "to": (0.01, 0.01, 0.1)}
        )
    )
    assert turned.problem.setup.heading == pytest.approx(np.radians(angle), rel=1e-15)
    assert straight.problem.setup.heading == 0.0
    times = np.linspace(0.0, turned.scene.duration, 101)
    one, other = (case.reference.observe(times) for case in (turned, straight))
    path = turned.problem.reference.motion.path
    push = np.abs(path.kinematics(np.linspace(0.0, path.duration, 1000))[2]).max()
    late = 4.0 * ULP * path.duration * push  # velocity, as times of manoeuvres are sums
    for name, values in one.items():
        bound = ROUND * max(1.0, float(np.abs(values).max())) + late * name.startswith(
            "velocity"
        )
        turn = np.radians(angle) * (name == "heading")
        np.testing.assert_allclose(values - turn, other[name], rtol=0, atol=bound, err_msg=name)
