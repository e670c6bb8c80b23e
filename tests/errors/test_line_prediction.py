"""The predicted error of a fixed step at every grid time: against the schemes run step by step."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from plumbob.analytic.errors.sliding_motion.sliding_errors import coasting_errors, line_errors
from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.analytic.systems.manoeuvres.repeated_line import RepeatedLine
from plumbob.analytic.systems.manoeuvres.residual_motion import coasting
from plumbob.analytic.systems.manoeuvres.slow_motion import SlowStroke
from plumbob.tests.support.fixed_step import mean_acceleration
from plumbob.tests.support.random_capsules import CHECK, LIMIT, LINE

LIMITING = CHECK.friction * CHECK.gravity
REPEATED = RepeatedLine(
    LINE, 3, 0.9, pause=0.32 - LINE.t2 - RepeatedLine(LINE, 1, 0.9).return_motion.duration
)
ROUNDING = 1e-11  # of forces of 4 N from differences over a step; places keep 1e-14 m
OFF_GRID = replace(LINE, t1=0.0317)


def friction(v, w, step):
    """Acceleration by Coulomb friction that aims at rest within `step`, against mu w."""
    return float(np.clip(-v / step + CHECK.mass_ratio * w, -LIMITING, LIMITING))


def simulated(control, step, scheme, velocity=0.0):
    """Body and slider at grid times, w held over each step."""
    mu = CHECK.mass_ratio
    (x, v, xi, rate) = (0.0, velocity, 0.0, 0.0)
    rows = [(x, v, xi, rate)]
    forces = []
    drives = []
    for held in control.tolist():
        first = friction(v, held, step) - mu * held
        forces.append(CHECK.weight / CHECK.gravity * (first + mu * held))
        drives.append(CHECK.slider_mass * (first + held))
        stages = [first]
        if scheme == RK4:
            for part in (0.5, 0.5, 1.0):
                late = v + part * step * stages[-1]
                stages.append(friction(late, held, step) - mu * held)
            gained = step / 6 * np.dot(stages, [1, 2, 2, 1])
            x = x + step * v + step**2 / 6 * sum(stages[:3])
            v = v + gained
            xi = xi + step * rate + step**2 / 2 * held
            rate = rate + step * held
        else:
            v = v + step * first
            rate = rate + step * held
            x = x + step * v
            xi = xi + step * rate
        rows.append((x, v, xi, rate))
    names = (
        "displacement",
        "velocity",
        "stroke",
        "stroke_rate",
        "friction_force",
        "driving_force",
    )
    of_steps = (np.append(values, np.nan) for values in (forces, drives))
    return dict(zip(names, (*np.array(rows).T, *of_steps), strict=True))


def left(motion, reference, step, scheme, end, wrong=None):
    """Largest part of each observable's error [SI] not explained by theory or rounding."""
    times = np.arange(round(end / step) + 1, dtype=np.float64) * step
    theory = partial(line_errors, wrong or motion, reference)
    found = simulated(mean_acceleration(motion, times), step, scheme)
    exact = reference.observe(times)
    predicted = theory(Scheme(scheme), step, times).errors
    doubt = reference.uncertainty(times)
    return {
        name: float(
            np.nanmax(np.abs(found[name] - exact[name] - predicted[name]) - doubt[name])
        )
        for name in found
        if name in predicted
    }


@pytest.mark.parametrize("scheme", [EULER, RK4])
@pytest.mark.parametrize("step", [1e-3, 3.7e-4, 1e-4])
@pytest.mark.parametrize("line", [LINE, OFF_GRID, replace(LINE, w2=0.3 * LIMIT)])
def test_line(line, step, scheme):
    unexplained = left(line, line, step, scheme, line.t2 + 0.01)
    assert max(unexplained.values()) < ROUNDING, unexplained
    assert {"friction_force", "driving_force"} <= set(unexplained)


@pytest.mark.parametrize("scheme", [EULER, RK4])
@pytest.mark.parametrize("beside", [0.0, 1e-6, 1e-3, 0.5])
def test_repeated_lines(scheme, beside):
    """Starts between two steps included: friction is held for a whole step against a push that
    lasts for a part of it, which leaves a velocity."""
    step = 1e-3
    motion = replace(REPEATED, pause=REPEATED.pause + beside * step)
    unexplained = left(motion, motion, step, scheme, motion.duration)
    assert max(unexplained.values()) < ROUNDING, unexplained


@pytest.mark.parametrize("both", [True, False])
def test_slow_stroke(both):
    stroke = SlowStroke(CHECK, 0.08, 0.9, there_and_back=both)
    unexplained = left(stroke, stroke, 7e-4, EULER, stroke.duration + 0.01)
    assert max(unexplained.values()) < ROUNDING, unexplained


@pytest.mark.parametrize("scheme", [EULER, RK4])
@pytest.mark.parametrize("speed", [0.4, -0.4])
def test_coasting(speed, scheme):
    motion = coasting(CHECK, (0.05, 0.0), (speed, 0.0))
    step = 1e-3
    times = np.arange(200, dtype=np.float64) * step
    found = simulated(np.zeros(199), step, scheme, speed)
    exact = motion.observe(times)
    predicted = coasting_errors(motion, Scheme(scheme), step, times)
    for name, like in (("x", "displacement"), ("velocity_x", "velocity")):
        np.testing.assert_allclose(
            found[like], exact[name] + predicted[name], rtol=0, atol=1e-14
        )


@pytest.mark.parametrize(
    "perturb",
    [
        lambda line: replace(line, capsule=replace(line.capsule, friction=0.3 * (1 + 1e-4))),
        lambda line: replace(line, w2=line.w2 * (1 - 1e-4)),
        lambda line: replace(line, t1=line.t1 * (1 + 1e-4)),
    ],
)
def test_a_small_change_is_not_predicted(perturb):
    wrong = perturb(LINE)
    unexplained = left(LINE, wrong, 1e-3, EULER, 0.15, wrong)
    assert unexplained["displacement"] > 1e3 * ROUNDING
