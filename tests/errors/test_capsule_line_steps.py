"""Effect of a fixed step on capsule motions: theory against the scheme run step by step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from plumbob.analytic.errors.sliding_motion.sliding_errors import (
    Sampling,
    coasting_step_error,
    leftover_stroke_rate,
    line_errors,
    step_error,
    step_error_envelope,
)
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import EULER, Scheme
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.analytic.systems.manoeuvres.residual_motion import Coasting
from plumbob.tests.support.fixed_step import mean_acceleration
from plumbob.tests.support.random_capsules import CHECK, LINE, lines


@dataclass(frozen=True)
class Run:
    """Places and rates at the grid times, the start included."""

    x: Array
    v: Array
    rate: Array


def simulate(
    control: Array,
    step: float,
    mu: float,
    friction_limit: float,
    v: float = 0.0,
    position_first: bool = False,
) -> Run:
    """Semi-implicit Euler with friction resolved within the step, until the body rests."""
    xs, vs, rates = [0.0], [v], [0.0]
    steps = iter(control)
    while (w := next(steps, None)) is not None or vs[-1] != 0.0:
        free = vs[-1] - mu * float(w or 0.0) * step
        v = np.sign(free) * max(abs(free) - friction_limit * step, 0.0)
        xs.append(xs[-1] + (vs[-1] if position_first else v) * step)
        vs.append(v)
        rates.append(rates[-1] + float(w or 0.0) * step)
    return Run(np.array(xs), np.array(vs), np.array(rates))


def grid(step: float, count: int) -> Array:
    return np.asarray(step * np.arange(count + 1), dtype=np.float64)


def run_line(
    line: LineManoeuvre, step: float, sampling: Sampling, position_first: bool = False
) -> Run:
    count = int(np.ceil(line.t2 / step)) + 2
    edges = grid(step, count)
    control = (
        line.relative_acceleration(edges[:-1] + 0.5 * step)
        if sampling == "middle"
        else mean_acceleration(line, edges)
    )
    friction_limit = line.capsule.friction * line.capsule.gravity
    return simulate(
        control, step, line.capsule.mass_ratio, friction_limit, position_first=position_first
    )


def rounding(line: LineManoeuvre, run: Run) -> float:
    """Each step rounds v, and x accumulates that to the end."""
    mu, friction_limit = line.capsule.mass_ratio, line.capsule.friction * line.capsule.gravity
    reach = (mu * (line.w1 + line.w2) + friction_limit) * line.t2**2
    return 4 * run.x.size * 2.0**-53 * reach


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("sampling", ["middle", "mean"])
@pytest.mark.parametrize("position_first", [False, True])
@given(line=lines(), steps=st.floats(0.3, 60.0) | st.floats(0.5, 1.5))
def test_step_error_is_that_of_the_scheme(
    sampling: Sampling, position_first: bool, line: LineManoeuvre, steps: float
) -> None:
    """Any step, t1 and t2 off the grid, down to steps longer than the push."""
    step = max(line.t1 / steps, line.t2 / 3000)
    # With the middle of a step on a switch, rounding decides which w it reads.
    assume(all(abs((switch / step) % 1 - 0.5) > 1e-9 for switch in (line.t1, line.t2)))
    run = run_line(line, step, sampling, position_first)
    found = run.x[-1] - line.displacement
    assert abs(found - float(step_error(line, step, sampling))) <= rounding(line, run)
    if sampling == "middle":
        leftover = float(leftover_stroke_rate(line, step))
        assert abs(run.rate[-1] - leftover) <= 1e-15 * run.x.size * line.w1 * line.t2


@given(lines(), st.integers(1, 60))
def test_on_the_grid_the_error_is_a_sawtooth(line: LineManoeuvre, count: int) -> None:
    step = line.t1 / count
    part = (line.t_star / step) % 1.0
    tooth = -0.5 * part * (1 - part) * line.closed.braking * step**2
    envelope = float(step_error_envelope(line, step))
    # The fraction is that of t_star/dt, which has a few roundings.
    near = 1e-14 * (line.t_star / step + 1) * envelope + 1e-14 * abs(line.displacement)
    assume(line.t2 - line.t_star > step)  # or the pull may be cut short before the body rests
    assert abs(float(step_error(line, step)) - tooth) <= near
    assert abs(float(step_error(line, step, "mean")) - tooth) <= near
    assert abs(tooth) <= envelope * (1 + 1e-15)


@pytest.mark.parametrize(
    "position_first",
    [False, True],
)
def test_leading_error_while_moving(position_first: bool) -> None:
    """t1 on the grid; until t_star the error is of first order only."""
    step = LINE.t1 / 37
    run = run_line(LINE, step, "middle", position_first)
    times = grid(step, run.x.size - 1)
    moving = times < LINE.t_star
    scheme = Scheme(EULER, position_first=position_first)
    error = line_errors(LINE, scheme, step, times)["displacement"]
    lead = (-0.5 if position_first else 0.5) * LINE.body_velocity(times)
    np.testing.assert_allclose(error[moving], step * lead[moving], rtol=0, atol=1e-17)
    left = run.x - LINE.body_displacement(times) - error
    assert np.abs(left[moving]).max() <= rounding(LINE, run)


def test_sensitivity() -> None:
    """A friction or mass error of 1e-4 changes the result by more than the whole error of a fine
    step."""
    step = 1e-5
    wrong = (replace(CHECK, friction=0.30003), replace(CHECK, slider_mass=0.30003))
    for capsule in (CHECK, *wrong):
        run = run_line(replace(LINE, capsule=capsule), step, "middle")
        off = abs(run.x[-1] - LINE.displacement - float(step_error(LINE, step)))
        large = max(rounding(LINE, run), float(step_error_envelope(LINE, step)))
        assert off > 99 * large if capsule in wrong else off <= rounding(LINE, run)


@pytest.mark.parametrize("position_first", [False, True])
@given(rate=st.floats(0.01, 10.0), steps=st.floats(0.3, 500.0), sign=st.sampled_from([-1, 1]))
def test_step_error_of_coasting(position_first: bool, rate: float, steps: float, sign: int) -> None:
    coasting = Coasting(sign * rate, 2.943)
    step = coasting.duration / steps
    run = simulate(np.zeros(0), step, 0.0, 2.943, sign * rate, position_first)
    predicted = coasting_step_error(coasting, step, -0.5 if position_first else 0.5)
    slack = 4 * run.x.size * 2.0**-53 * (rate * coasting.duration + rate * step)
    assert abs(run.x[-1] - coasting.distance - float(predicted)) <= slack
