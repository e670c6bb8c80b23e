"""A search finds what is known to be worst, and is not sure where the exact answer is wrong."""

import math
from dataclasses import replace

import pytest

from plumbob.engines.box import Side, box
from plumbob.engines.registry import method
from plumbob.engines.study.measurement import measure
from plumbob.engines.sweep.worst import SURE, certificate, search
from plumbob.models.registry import case_of, scene
from plumbob.reports.commands.worst import tolerance_fraction
from plumbob.reports.judge.verdict import judge

EULER = method("mujoco/euler")
AROUND = Side("heading", 0.0, 2.0 * math.pi)


class _Off:
    """An exact answer with all observables multiplied by a factor."""

    def __init__(self, true, factor):
        self._true, self._factor = true, factor

    def observe(self, times):
        return {n: self._factor * values for n, values in self._true.observe(times).items()}

    def __getattr__(self, name):
        return getattr(self._true, name)


def spoilt(case, factor):
    """The case with an exact answer that is off."""
    return replace(case, reference=_Off(case.reference, factor))


@pytest.mark.long
def test_the_worst_heading_for_default_contacts():
    found = search(box("capsule-line", {}, [AROUND]), EULER, 1e-3, 60)
    assert found.error > 0.34
    assert found.runs <= 60
    assert found.certain
    assert found.certificate is not None
    assert not replace(found, certificate=replace(found.certificate, distance=0.1)).certain
    assert not replace(found, certificate=None).certain
    # A box that opens in x and y alike is worst half-way between them.
    assert found.parameters["heading"] % (math.pi / 2) == pytest.approx(math.pi / 4, abs=1e-2)


@pytest.mark.long
@pytest.mark.parametrize(("factor", "certain"), [(1.0, True), (1.5, False)])
def test_a_wrong_exact_answer_is_not_confirmed(factor, certain):
    case = spoilt(case_of(scene("capsule-line", {"heading": math.pi / 4})), factor)
    held = certificate(case, EULER)
    assert held
    assert (held.distance <= SURE * 0.34) is certain


@pytest.mark.long(keep=2)
@pytest.mark.parametrize(
    ("name", "tried", "factor", "fails"),
    [
        ("capsule-line", "mujoco/euler+coulomb", 1.0, False),
        ("capsule-line", "mujoco/euler+coulomb", 1.0 + 1e-3, True),
        ("simple-pendulum", "mujoco/rk4", 1.0, False),
        ("simple-pendulum", "mujoco/rk4", 1.0 + 1e-6, True),
        ("simple-pendulum", "ode/dop853", 1.0, False),
        ("simple-pendulum", "ode/dop853", 1.0 + 1e-3, True),
    ],
)
def test_more_than_all_of_a_tolerance_is_a_failure(name, tried, factor, fails):
    case = spoilt(case_of(scene(name)), factor)
    chosen = method(tried)
    step = chosen.step_sizes[-1] if chosen.control == "tolerance" else 1e-3
    found, _ = measure(case, chosen, step)
    verdict = judge(found, case.system, chosen, case.system.quantities(case)).verdict
    assert (verdict == "off-prediction") is fails
    assert (tolerance_fraction(case, chosen, step) > 1.0) is fails
