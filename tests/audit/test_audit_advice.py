"""what an audit advises: an option that a file takes, which does what was measured."""

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import MujocoModel, own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import audited
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.costs import TURNS, Ratio
from plumbob.engines.audit.reference import OUT_OF_TIME, certified
from plumbob.engines.audit.step_errors import (
    Cheapest,
    StepError,
    cheapest_step,
    compare_steps,
    error_at_step,
    observed_order,
)
from plumbob.engines.method import Stepping
from plumbob.engines.study import cost as cost_module
from plumbob.engines.study.cost import Cost
from plumbob.reports.view.audit.page import answer_rows, audit_answer
from plumbob.tests.audit.scenes_as_models import (
    PENDULUM,
    ball,
    compiled,
    pendulum,
    ready,
    recast,
)


@pytest.fixture(name="found", scope="module")
def _found():
    model = ready(pendulum())
    return audited(model, script(model, duration=0.4), "rest", Allowance(20.0))


def to_do(found):
    return dict(answer_rows(audit_answer(found)))["to do"]


def choosing(found, *chosen):
    assert found.found is not None
    return to_do(replace(found, found=replace(found.found, cheapest=chosen)))


def times(value):
    return Ratio(value, 0.9 * value, 1.1 * value)


def test_what_is_advised_depends_on_the_error(found):
    assert 1e-2 < found.error < 0.1
    near = Cheapest(1e-2, "rk4", 0.005, 1e-3, times(2.0))
    same = Cheapest(0.1, "euler", 0.02, 0.09, times(0.5))
    assert choosing(found, same, near) == (
        'for 1 cm: in <option> timestep="0.005" in place of 0.01 and integrator="RK4" in place of '
        'Euler (×2 [1.8, 2.2]); enough for 10 cm: in <option> timestep="0.02" in place of 0.01 '
        "(×0.5 [0.45, 0.55])"
    )
    assert 'refsafe="disable"' in choosing(found, replace(near, unguarded=True))
    assert "at a risk" in choosing(found, replace(near, unguarded=True))
    assert choosing(found, replace(near, cost=None)).endswith("in place of Euler")
    assert choosing(found) == "no step that was run is reliably nearer"
    assert choosing(replace(found, clamped={"geom_solref": 2})).endswith(
        "; before another step, raise geom_solref to 20 ms in the file"
    )
    capped = replace(found.found, own=replace(found.found.own, remarks=("at its cap",)))
    assert "give the solver more iterations" in to_do(replace(found, found=capped))
    ended = replace(found.reference, why=f"{OUT_OF_TIME} at 0.25 s")
    short = replace(found.found, index=10, cheapest=(same, near))
    assert to_do(replace(found, found=short, reference=ended)).endswith(
        "2.2]) up to 0.2 s; a larger --budget tells more"
    )
    # its spread reaches 0.825
    as_large = Cheapest(0.1, "implicitfast", 0.01, 0.09, times(0.75))
    assert choosing(found, as_large) == "no step that was run is reliably nearer"
    assert "enough for 10 cm" in choosing(found, replace(as_large, cost=times(0.7)))
    assert to_do(replace(found, found=None)).startswith("try a shorter --duration")


@pytest.mark.parametrize(
    ("solref", "flags", "unguarded"),
    [
        (".02 1", 'energy="disable"', True),  # refsafe raises 20 ms to 40 ms
        (".05 1", 'energy="disable"', False),
        (".02 1", 'refsafe="disable"', False),  # the file has it off
        (".02 1", 'contact="disable"', False),  # nothing to soften
        (".02 1", 'constraint="disable"', False),
    ],
)
def test_refsafe_is_advised_where_it_makes_a_difference(solref, flags, unguarded):
    own = own_model(ball(solref=solref, flags=flags), "ball")
    assert own.softened(0.02) == unguarded
    assert not own.softened(0.001)  # its own
    assert own.option("euler", 0.02) == {"timestep": ("0.001", "0.02")}
    assert own.option("rk4", 0.001) == {"integrator": ("Euler", "RK4")}


def run(step, error, cost, integrator="euler"):
    """A run at a step that costs `cost` in a second."""
    ns = cost * step
    costs = Cost(ns, 0.9 * ns, 1.1 * ns, 1.0, 0.0, 5)
    errors = np.array([0.0, error])
    return StepError(integrator, step, 1, errors, "rod", 0.0, cost=costs)


def test_a_step_is_cheapest_only_where_every_smaller_one_is_as_good(found):
    known = replace(found.reference, uncertainty=np.array([0.0, 1e-6]))
    steps = [run(4.0, 5e-4, 1.0), run(2.0, 3e-3, 2.0), run(1.0, 8e-4, 4.0), run(0.5, 4e-4, 8.0)]
    best = cheapest_step(steps, steps[1], known, 1, 1e-3)
    assert replace(best, cost=None) == Cheapest(1e-3, "euler", 1.0, 8e-4, None)
    spread = 1.0 + math.hypot(0.1, 0.1)  # of both: independent of each other
    assert (best.cost.low, best.cost.value, best.cost.high) == pytest.approx(
        (2.0 / spread, 2.0, 2.0 * spread)
    )
    assert cheapest_step(steps[:2], steps[1], known, 1, 1e-3) is None
    assert (
        cheapest_step(steps, steps[1], known, 1, 4e-6) is None
    )  # known to a quarter of it only
    ended = replace(steps[2], cost=None)
    assert cheapest_step([ended, steps[3]], ended, known, 1, 1e-3) == Cheapest(
        1e-3, "euler", 0.5, 4e-4, None
    )


@pytest.mark.parametrize("cost", [0.81, 0.99, 1.0, 1.01, 1.24])
def test_where_costs_are_alike_the_choice_is_kept(found, cost):
    """A difference that scatters from call to call decides nothing; a clear one does."""
    known = replace(found.reference, uncertainty=np.array([0.0, 1e-6]))
    own = run(1.0, 8e-4, 1.0)
    best = cheapest_step([run(2.0, 8e-4, cost, "rk4"), own], own, known, 1, 1e-3)
    assert (best.integrator, best.cost) == ("euler", Ratio(1.0, 1.0, 1.0))
    best = cheapest_step([run(2.0, 8e-4, 0.79, "rk4"), own], own, known, 1, 1e-3)
    assert best.integrator == "rk4"


@dataclass(frozen=True)
class Clocked(MujocoModel):
    """A model whose steps take 1 µs, RK4's 4 µs; but ten times as long when they are timed first,
    and in a slow spell of the machine, which the reference steps beside are in, too."""

    def timed(self, script, states, integrator, parts, steps):
        turns = iter((10.0, 1.0, 3.0, 1.0, 1.0, *[1.0] * TURNS))
        pace = 4e-6 if integrator == "rk4" else 1e-6
        count = len(states) * steps
        return SimpleNamespace(
            compile_seconds=0.0, stepped=lambda _: Stepping(count, count * pace * next(turns))
        )


def test_costs_are_warm_and_beside_reference_steps(monkeypatch):
    """A time that is taken once, and cold, decides nothing, whatever the length of a run."""
    monkeypatch.setattr(cost_module, "reference_step", lambda _: lambda: 500.0)
    own = recast(Clocked, own_model(pendulum(), "rod"))
    motion = script(own, duration=0.1)
    found = compare_steps(own, motion, certified(own, motion, Allowance(20.0)), Allowance(20.0))
    for step in found.steps:
        pace = 4000.0 if step.integrator == "rk4" else 1000.0
        assert step.cost.ns_per_step == pytest.approx(pace)
        assert step.ns_per_second == pytest.approx(pace / step.step)
        assert step.cost.low <= step.cost.ns_per_step <= step.cost.high
    near = found.cheapest[-1]
    pace = 4.0 if near.integrator == "rk4" else 1.0
    assert near.cost.value == pytest.approx(pace * 0.01 / near.step)


def test_the_worst_body_is_the_one_that_is_furthest_off():
    """A rod on a rod: the second one has the larger error."""
    text = PENDULUM.format(integrator="Euler").replace(
        "</body>", '<body name="tip" pos=".5 0 0"><geom size=".02" pos=".2 0 0"/></body></body>'
    )
    model = ready(compiled(text))
    motion = script(model, duration=0.2)
    known = certified(model, motion, Allowance(20.0))
    assert error_at_step(model, motion, known, "euler", 2).worst == "tip"


@pytest.mark.parametrize(
    ("errors", "said"),
    [
        ((5.5e-3, 3e-3), "5.5 mm -> at most 3.7 mm: the reference shows no smaller errors"),
        ((5.5e-3, 4e-3), "hardly helps: 5.5 mm -> 4 mm"),
        ((3e-3, 1e-3), "not resolved: the reference shows only errors above 3.5 mm"),
        ((math.inf, math.inf, 1e-3), "needed: steps hold from 2.5 ms down"),
        ((math.inf, math.inf), "no step holds, down to 5 ms"),
    ],
)
def test_halving_says_what_the_reference_tells(found, errors, said):
    """An error of 5.5 mm that is known to 0.7 mm is not within what the reference resolves."""
    assert found.found is not None
    steps = tuple(run(0.01 / 2**k, error, 1.0) for k, error in enumerate(errors))
    known = replace(found.reference, uncertainty=np.array([0.0, 0.7e-3]))
    short = replace(found.found, own=steps[0], steps=steps, index=1, order=None)
    motion = replace(found.script, controls=found.script.controls[:1])
    answer = audit_answer(replace(found, script=motion, reference=known, found=short))
    assert dict(answer_rows(answer))["halving"] == said


def test_an_order_is_that_of_errors_that_the_reference_resolves(found):
    """Errors of second order above what is known; below that they go up and down."""
    known = replace(found.reference, uncertainty=np.array([0.0, 1e-6]))
    steps = [run(2.0**-k, 4.0**-k, 1.0) for k in range(8)]
    steps += [run(2.0**-k, 4e-6, 1.0) for k in range(9, 12)]
    order = observed_order(steps, known, 1)
    assert (order.low, order.slope, order.high) == pytest.approx((2.0, 2.0, 2.0))
