"""Controls that are functions of time: each step has its own, however many are read at once."""

from itertools import pairwise

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.capsule.readings import control
from plumbob.engines.controlled_steps import READ_AHEAD, controlled_steps
from plumbob.models.registry import case_of, scene

STEP = 1e-4  # [s]
# First and last indices of the steps from sample to sample: none, few, and more than are read ahead
ENDS = (0, 0, 3, 4, READ_AHEAD - 1, READ_AHEAD + 2, 3 * READ_AHEAD, 3 * READ_AHEAD + 1)


class Recorded:
    """A stepper that keeps the controls of its steps."""

    def __init__(self):
        self.rows = []

    def advance(self, controls, steps):
        """Keeps the controls of so many steps."""
        assert len(controls) == steps
        self.rows += [*controls]


@pytest.mark.parametrize("place", [0.0, 0.5])
@pytest.mark.parametrize("name", ["capsule-line/ca1", "capsule-train/ten", "capsule-turn/0.3"])
def test_each_step_has_the_controls_of_its_own_time(name, place):
    """To the bit those that are read for this step alone."""
    controls = control(case_of(scene(name)).problem.setup, STEP)
    calls = []

    def counted(times):
        calls.append(times)
        return controls(times)

    stepper = Recorded()
    take_steps = controlled_steps(stepper, counted, STEP, place)
    for first, last in pairwise(ENDS):
        take_steps(first, last)
    times = (np.arange(ENDS[-1], dtype=np.float64) + place) * STEP
    alone = np.concatenate([controls(times[k : k + 1]) for k in range(len(times))])
    assert np.array_equal(np.array(stepper.rows), alone)
    assert len(calls) <= 4
