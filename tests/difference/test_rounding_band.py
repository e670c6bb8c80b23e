"""The growth of rounding differences by step Jacobians, against sums that are written out."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.errors.rounding_band import LARGEST, StepRounding, carried_band

STEPS, SIZE, NUDGES = 30, 4, 6
# The same sums of products in two orders: each of 30 products of 4 x 4 matrices rounds by some
# units in the last place of its largest term, which grows with the condition of the products.
ROUNDED = 1e-10


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
    squares = (nudged**2).sum(axis=(0, 1)) / NUDGES
    assert last.estimate == pytest.approx(np.sqrt(squares), rel=ROUNDED)
    left = parts_at_the_end(steps, [step.left for step in steps])
    squares = (left**2).sum(axis=0)
    assert last.solver == pytest.approx(LARGEST * np.sqrt(STEPS * squares), rel=ROUNDED)
    assert (last.solver >= np.abs(left).sum(axis=0)).all()
    carried = parts_at_the_end([steps[0], *steps], [start])[0]
    assert last.start == pytest.approx(np.abs(carried), rel=ROUNDED)
    assert last.bound == pytest.approx(last.rounding + last.solver + last.start, rel=ROUNDED)


def test_what_two_solvers_leave_adds_up_in_squares():
    steps = list(random_steps(3))
    other = [step.nudged[0] for step in steps]
    both = [
        replace(step, left=np.stack([step.left, row]))
        for step, row in zip(steps, other, strict=True)
    ]
    ends = [
        [*carried_band(rows, np.zeros(SIZE))][-1].solver
        for rows in (
            steps,
            [replace(step, left=row) for step, row in zip(steps, other, strict=True)],
            both,
        )
    ]
    assert ends[2] == pytest.approx(np.hypot(*ends[:2]), rel=ROUNDED)
    assert (ends[2] > 1.0001 * np.maximum(*ends[:2])).any()


def test_the_bound_holds_if_all_steps_round_the_same_way_and_is_reached():
    """Parts of one sign add up to the bound over LARGEST if all are equally large."""
    equal = [StepRounding(np.eye(1), np.array([[1.0], [-1.0]]), np.zeros(1))] * 100
    *_, last = carried_band(equal, np.zeros(1))
    # Sums of a hundred ones and their roots are exact.
    assert last.estimate == [10.0]
    assert last.rounding == [100.0 * LARGEST]


@pytest.mark.parametrize("factor", [0.99, 1.01])
def test_one_jacobian_that_is_wrong_by_a_hundredth_shows(factor):
    """The right band is known to ROUNDED; one wrong factor of thirty moves it by a hundredth of the
    steps before, here a thousandth of the whole, and by no more than a hundredth."""
    steps = list(random_steps(2))
    *_, right = carried_band(steps, np.zeros(SIZE))
    middle = steps[STEPS // 2]
    steps[STEPS // 2] = StepRounding(factor * middle.jacobian, middle.nudged, middle.left)
    *_, wrong = carried_band(steps, np.zeros(SIZE))
    moved = np.abs(wrong.estimate / right.estimate - 1.0)
    assert 1e-4 < moved.max() <= 0.0101
