"""The growth of rounding differences by step Jacobians, against sums that are written out."""

import numpy as np
import pytest

from plumbob.analytic.errors.rounding_band import LARGEST, StepRounding, carried_band

STEPS, SIZE, NUDGES = 30, 4, 6


def random_steps(seed):
    rng = np.random.default_rng(seed)
    for _ in range(STEPS):
        yield StepRounding(
            np.eye(SIZE) + 0.3 * rng.standard_normal((SIZE, SIZE)),
            rng.standard_normal((NUDGES, SIZE)),
            rng.standard_normal(SIZE),
        )


def parts_at_the_end(steps, rows):
    """The row that each step adds, multiplied by the Jacobians of all later steps."""
    ends = []
    for number, added in enumerate(rows):
        for step in steps[number + 1 :]:
            added = added @ step.jacobian.T
        ends.append(added)
    return np.array(ends)


def test_the_band_is_the_sum_of_all_steps_carried_to_the_end():
    steps = list(random_steps(1))
    start = np.array([1e-3, 0.0, 0.0, -2e-3])
    *_, last = carried_band(steps, start)
    nudged = parts_at_the_end(steps, [step.nudged for step in steps])
    assert last.estimate == pytest.approx(np.sqrt((nudged**2).sum(axis=(0, 1)) / NUDGES))
    left = parts_at_the_end(steps, [step.left for step in steps])
    assert (last.solver >= np.abs(left).sum(axis=0)).all()
    carried = parts_at_the_end([steps[0], *steps], [start])[0]
    assert last.start == pytest.approx(np.abs(carried))
    assert (last.bound >= last.rounding + last.start).all()


def test_the_bound_holds_if_all_steps_round_the_same_way_and_is_reached():
    """Parts of one sign add up to the bound over LARGEST if all are equally large."""
    equal = [StepRounding(np.eye(1), np.array([[1.0], [-1.0]]), np.zeros(1))] * 100
    *_, last = carried_band(equal, np.zeros(1))
    assert last.estimate == pytest.approx(10.0)
    assert last.rounding == pytest.approx(100.0 * LARGEST)


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_one_jacobian_that_is_wrong_by_a_hundredth_shows(factor):
    steps = list(random_steps(2))
    *_, right = carried_band(steps, np.zeros(SIZE))
    middle = steps[STEPS // 2]
    steps[STEPS // 2] = StepRounding(factor * middle.jacobian, middle.nudged, middle.left)
    *_, wrong = carried_band(steps, np.zeros(SIZE))
    assert wrong.estimate != pytest.approx(right.estimate, rel=1e-4)
