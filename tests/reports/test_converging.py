"""The verdict `converges`: an envelope that falls with the step, and nothing that stays."""

import numpy as np
import pytest

from plumbob.engines.study.convergence import steps_between
from plumbob.engines.study.measurement import Measurement, ObservedError
from plumbob.models.scene import Quantity
from plumbob.reports.judge.converging import convergence

ABOUT = (Quantity("x", 2.0),)
STEPS = steps_between((1e-2, 1e-4), 1.0, own=False)


def verdict(error, steps=STEPS, uncertainty=1e-16):
    """What errors at steps show."""
    runs = []
    for step in steps:
        x = error(step)
        errors = {"x": ObservedError(abs(x), x, uncertainty, 2.0)}
        runs.append(Measurement("s", "m", step, "done", errors=errors, steps=round(1.0 / step)))
    found = convergence(runs, ABOUT)
    return found.verdict, found.reason


def saw(step):
    """Between 0.2 and 1, from the place of a switch within a step."""
    return 0.2 + 0.8 * ((0.123456789 / step) % 1.0)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_errors_that_fall_as_a_power_of_the_step_converge(order):
    found, why = verdict(lambda h: 3.0 * h**order * (1.0 + 5.0 * h))
    assert found == "converges"
    assert f"of order {order}" in why.replace("0.99", "1").replace("1.99", "2")
    assert "the smallest error resolved is" in why


def test_a_sawtooth_that_falls_with_the_step_converges():
    assert verdict(lambda h: 0.5 * h * saw(h))[0] == "converges"


@pytest.mark.parametrize("least", [0.05, 5e-3, 5e-4, 2e-4])
def test_a_plateau_does_not_converge(least):
    """One that is as large as the error of the finest step, 1e-4, and not only one that is seen."""
    assert verdict(lambda h: h + least)[0] == "not-converging"
    assert verdict(lambda h: h * saw(h) + 20.0 * least)[0] != "converges"


def test_a_plateau_of_an_exact_zero_has_no_round_off_level():
    """A body at rest is known without rounding: a drift is no multiple of a round-off level."""
    found, why = verdict(lambda h: 1e-6, uncertainty=0.0)
    assert (found, why) == ("not-converging", "the relative error stays at 5e-07")


def test_errors_at_the_round_off_level_converge():
    assert verdict(lambda h: 1e-16 * saw(h))[0] == "converges"
    assert verdict(lambda h: 1e-12 * saw(h))[0] == "not-converging"  # far above it


def test_runs_that_end_early_since_all_are_at_the_round_off_level_converge():
    """A study ends two steps after its error is at the floor, on fewer octaves than are needed."""
    assert verdict(lambda h: 0.0, STEPS[:3])[0] == "converges"
    assert verdict(lambda h: 0.0, STEPS[:2])[0] is None
    assert verdict(lambda h: 1e-12 if h == STEPS[0] else 0.0, STEPS[:3])[0] is None


def test_steps_between():
    octaves = np.log2(np.array(steps_between((1e-2, 1e-3), 10.0, own=False)) / 1e-3)
    assert octaves.max() == pytest.approx(5.0)  # coarser than those given
    assert np.diff(octaves) == pytest.approx(-1.0 / 3.0)
    assert max(steps_between((1e-2, 1e-3), 10.0, own=True)) <= 1e-2
    assert max(steps_between((1e-2, 1e-3), 0.08, own=False)) <= 1e-2  # eight steps in a run
