"""Calibrated constants of sequential impulses, each confirmed from both sides by runs of pymunk."""

from dataclasses import replace

import pytest

from plumbob.analytic.errors.contact_models.model_error import sample_motion
from plumbob.analytic.errors.contact_models.sequential_impulse_bounds import (
    RESIDUAL_FRACTION,
    STALLING_SPARE_FRICTION,
    solver_demand,
)
from plumbob.engines.adapters.pymunk.capsule import described
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene, system_of
from plumbob.tests.support.cases import beyond
from plumbob.tests.support.pymunk_capsule import METHODS, run

USED_UP_SCENES = (
    ("capsule-line/w1-threshold", 1e-3),
    ("capsule-line/w2-threshold", 1e-3),
    ("capsule-hold/slow-motion", 1e-3),
)


def residual(name, step, iterations, **changes):
    """Fraction of the change of velocity that feet leave in a step, and its bound with one sticking
    foot."""
    changed = scene(name, changes)
    case = case_of(changed)
    feet = METHODS["feet"]
    feet = replace(feet, settings={**feet.settings, "iterations": iterations})
    solver = described(case.problem, feet, step)
    assert solver.iterations == iterations
    jump = solver_demand(case.problem, sample_motion(case.problem, changed.duration)).jump
    velocity = measure(case, feet, step)[0].errors["velocity"]
    return beyond(velocity) / (jump * step), solver.one_foot_residual


def test_residual_where_friction_is_used_up():
    """RESIDUAL_FRACTION is at most twice the residual of 50 iterations; it is still three times
    that of 200, far above the bound of one sticking foot."""
    few = [residual(name, step, 50)[0] for name, step in USED_UP_SCENES]
    assert 0.5 * RESIDUAL_FRACTION < max(few) < RESIDUAL_FRACTION
    left, one_foot = residual("capsule-line/w2-threshold", 1e-3, 200)
    assert left < RESIDUAL_FRACTION
    assert left > 1e3 * one_foot


@pytest.mark.parametrize(
    ("name", "changes"),
    [("capsule-line/ca1", 3), ("capsule-coast/rotation", 2), ("capsule-train/ten", 60)],
)
def test_forces_change_at_once_as_often_as_the_motion_says(name, changes):
    """As a body begins to slide and stops, and its slider stops; in repeated manoeuvres also as it
    begins to return, turns round, and stops again."""
    case = case_of(scene(name))
    assert (
        solver_demand(case.problem, sample_motion(case.problem, case.scene.duration)).changes
        == changes
    )


@pytest.mark.parametrize("iterations", [100, 200])
def test_friction_reserve_at_which_iterations_stall(iterations):
    """With a friction reserve of STALLING_SPARE_FRICTION, and with half of it, the bound of one
    sticking foot holds; with a twentieth it does not."""
    line = system_of(scene("capsule-line/w2-threshold")).problem(
        scene("capsule-line/w2-threshold").parameters
    )
    holding = line.motion.capsule.holding_acceleration
    for part, within in ((1.0, True), (0.5, True), (0.05, False)):
        spare = part * STALLING_SPARE_FRICTION
        left, one_foot = residual(
            "capsule-line/w2-threshold", 1e-3, iterations, w2=holding * (1.0 - spare)
        )
        assert (left < one_foot) == within


def test_roundings_from_positions_to_a_velocity():
    """ROUNDINGS is at most four times too large: the friction of ten manoeuvres at a long step has
    a third of its bound, all of it rounding."""
    force = run("capsule-train/ten", "side", 5e-3)[0].errors["friction_force"]
    bound = sum(force.model.values())
    assert force.model["rounding of positions"] > 0.99 * bound
    assert 0.25 * bound < beyond(force) < bound


@pytest.mark.parametrize(("after", "least", "most"), [(3e-3, 0.02, 1.0), (0.5, 0.0, 1e-6)])
def test_what_bare_pivots_leave_where_rest_falls_next_to_the_end_of_a_step(after, least, most):
    """The body turns about C and comes to rest this fraction of a step after the end of one: the
    solver pushes it aside by a thirtieth of the bound, and by nothing in the middle of a step."""
    step = 1e-3
    pivots = METHODS["pivots"]
    usual = scene("capsule-coast/rotation")
    coasting = system_of(usual).case(usual).problem.motion
    rate = coasting.deceleration * step * (round(coasting.sliding_time / step) + after)
    changed = scene("capsule-coast/rotation", {"heading_rate": rate})
    aside = measure(system_of(changed).case(changed), pivots, step)[0].errors["velocity_y"]
    bound = aside.model["solver iterations"]
    assert least * bound <= aside.largest < most * bound
