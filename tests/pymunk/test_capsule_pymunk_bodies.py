"""Any capsule in pymunk: random bodies, momentum, and mistakes that must fail the verdict."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.sequential_impulse import slipping_feet_factor
from plumbob.analytic.errors.sliding_motion.sliding_errors import step_error
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.manoeuvres.line_manoeuvre import LineManoeuvre
from plumbob.engines.adapters.pymunk import capsule
from plumbob.engines.adapters.pymunk.capsule_above import foot_mass
from plumbob.tests.support.pymunk_capsule import METHODS, moved, problem_of

# Two light feet: when the body is held from the other side they are at their limits.
UNEVEN = Capsule(1.0, 1.0, 0.02, ((0.2, 0.0), (-0.05, 0.1), (-0.1, -0.25)), 1.0, 9.81)


def uneven(friction):
    """A manoeuvre of that body, its accelerations in units of f g/mu and its times in f^(-1/2)."""
    body = replace(UNEVEN, friction=friction)
    holding = body.holding_acceleration
    return LineManoeuvre(body, 3 * holding, 0.9 * holding, 0.01 / math.sqrt(friction), 2.45)


def test_friction_sets_the_unit_of_time_alone():
    # The residual of the iterations is the same fraction of the displacement for every f: no
    # friction is difficult.
    ends = []
    for friction in (0.1, 1.0):
        line = uneven(friction)
        ends.append(moved(line, "feet", 0.03 * line.t2)["displacement"])
    assert ends[0] == pytest.approx(ends[1], rel=1e-12)


def test_with_light_feet_one_sticking_foot_stops_the_body():
    # The bound is that of one sticking foot; with two of them the same body would exceed it.
    line = uneven(1.0)
    method = METHODS["feet"]
    step = 0.03 * line.t2
    problem = problem_of(line)
    count = capsule.described(problem, method, step).iterations
    off = moved(line, "feet", step)["displacement"] - line.displacement
    off -= float(step_error(line, step))
    asked = line.closed.braking * step**2
    mass = foot_mass(line.capsule)
    one, two = (slipping_feet_factor(line.capsule, mass, n) ** count for n in (1, 2))
    assert 10 * two * asked < off < one * asked
    loads = line.normal_forces(np.array([line.t_star]))[0] / line.capsule.weight
    assert sorted(loads)[1] < 0.3 < 0.5 < loads.max()
