"""Effect of a fixed step on line manoeuvres: theory against the scheme run step by step."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbob.analytic.errors.sliding_motion.sliding_errors import step_error
from plumbob.tests.support.fixed_step import mean_acceleration
from plumbob.tests.support.random_capsules import CHECK, LINE, lines


def run_line(line, step, position_first=False):
    """Places of C at grid times: semi-implicit Euler, friction resolved within the step."""
    edges = step * np.arange(np.ceil(line.t2 / step) + 3.0)
    mu = line.capsule.mass_ratio
    limit = line.capsule.friction * line.capsule.gravity
    xs = [0.0]
    v = 0.0
    for w in mean_acceleration(line, edges):
        free = v - mu * float(w) * step
        before = v
        v = np.sign(free) * max(abs(free) - limit * step, 0.0)
        xs.append(xs[-1] + (before if position_first else v) * step)
    assert abs(v) <= 1e-12
    return np.array(xs)


def rounding(line, places):
    """Each step rounds v, and x accumulates that to the end."""
    mu = line.capsule.mass_ratio
    friction_limit = line.capsule.friction * line.capsule.gravity
    reach = (mu * (line.w1 + line.w2) + friction_limit) * line.t2**2
    return 4 * places.size * 2.0**-53 * reach


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("position_first", [False, True])
@given(line=lines(), steps=st.floats(0.3, 60.0) | st.floats(0.5, 1.5))
def test_step_error_is_that_of_the_scheme(position_first, line, steps):
    """Any step, t1 and t2 off the grid, down to steps longer than the push."""
    step = max(line.t1 / steps, line.t2 / 3000)
    places = run_line(line, step, position_first)
    off = places[-1] - line.displacement
    assert abs(off - float(step_error(line, step))) <= rounding(line, places)


def test_sensitivity():
    """A friction or mass error of 1e-4 changes the result by more than the whole error of a fine
    step."""
    step = 1e-5
    wrong = (replace(CHECK, friction=0.30003), replace(CHECK, slider_mass=0.30003))
    for capsule in (CHECK, *wrong):
        places = run_line(replace(LINE, capsule=capsule), step)
        off = abs(places[-1] - LINE.displacement - float(step_error(LINE, step)))
        large = max(rounding(LINE, places), LINE.closed.braking * step**2 / 8)
        assert off > 99 * large if capsule in wrong else off <= rounding(LINE, places)
