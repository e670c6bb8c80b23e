"""The exact three-point motion against formulas, an independent integrator and balances."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.slider_path import (
    line_stroke,
)
from plumbob.analytic.systems.three_points.friction import three_point_motion
from plumbob.tests.support.random_capsules import CHECK, LIMIT
from plumbob.tests.support.random_slides import COAST, ending, pose, slide
from plumbob.tests.support.smoothed_friction import smoothed_pose

# Formulas and motion agree to round-off: displacements of some mm, sums of some tens of elements.
ROUND = 1e-14


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.1, 5.0])
@pytest.mark.parametrize(
    ("capsule", "w1", "w2", "t1"),
    [
        (CHECK, 3 * LIMIT, 0.8 * LIMIT, 0.03),
        (CHECK, 3 * LIMIT, LIMIT, 0.03),  # sticks at the end
        (CHECK, (1 + 1e-6) * LIMIT, 0.5 * LIMIT, 0.03),  # hardly moved
        (CHECK, (1 + 1e-10) * LIMIT, 0.5 * LIMIT, 0.03),
        (replace(CHECK, slider_mass=1e-3), 2900.0 * 3, 2900.0 * 0.8, 0.003),
        (replace(CHECK, slider_mass=1e3), 2.946 * 3, 2.946 * 0.8, 0.003),
    ],
)
def test_a_line_manoeuvre_is_its_formula(capsule, w1, w2, t1, heading):
    line = LineManoeuvre(capsule, w1, w2, t1, heading)
    motion = three_point_motion(capsule, line_stroke((0.0, 0.0), heading, w1, w2, t1))
    times = np.linspace(0.0, 1.2 * line.t2, 41)
    at = motion.at(times)
    np.testing.assert_allclose(
        at.position, line.at(times).displacement[:, None] * line.unit, rtol=0, atol=ROUND
    )
    speeds = line.at(times).velocity[:, None] * line.unit
    np.testing.assert_allclose(at.velocity, speeds, rtol=0, atol=1e-12 * w1 * t1)
    assert np.abs(at.heading).max() <= ROUND
    assert motion.rest_time == pytest.approx(line.t_star, rel=1e-11)


def gradual(motion):
    """Whether a load grows through the friction limit within a piece."""
    return any(
        before.mode != "slide"
        and after.mode != "rest"
        and np.abs(motion.path.breakpoints - after.time).min() > 1e-12
        for before, after in itertools.pairwise(motion.events)
    )


@pytest.mark.long
def test_smoothed_friction_finds_the_same_pose(request):
    """50 slides with `--profile full`, a few otherwise; 1e-9 is the accuracy of the smoothed
    motion, whose measured error is up to 1e-10."""
    # 24: a support passes through rest; 26: a pivot while the slider moves; coasting ends in one.
    seeds = range(50) if request.config.getoption("--profile") == "full" else (24, 26)
    cases = [*((slide(seed), str(seed)) for seed in seeds), (COAST, "coast")]
    for case, name in cases:
        motion = case.motion()
        delta, order = (1e-9, 0.8) if gradual(motion) else (1e-8, 1.0)
        time = ending(motion)
        found = smoothed_pose(case.capsule, case.path, case.state, time, delta, order).pose
        assert np.abs(found - pose(motion, time)).max() <= 1e-9, name
