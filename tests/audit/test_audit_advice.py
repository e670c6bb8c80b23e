"""what an audit advises: an option that a file takes, which does what was measured."""

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import MujocoModel, own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import audited
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.costs import TURNS, Ratio
from plumbob.engines.audit.reference import OUT_OF_TIME, certified
from plumbob.engines.audit.stability import LargestSteps, Limit
from plumbob.engines.audit.step_errors import (
    StepError,
    compare_steps,
    error_at_step,
    observed_order,
)
from plumbob.engines.method import Stepping
from plumbob.engines.study import cost as cost_module
from plumbob.engines.study.cost import Cost
from plumbob.reports.advice.audit_advice import (
    StepChoice,
    StepEvidence,
    audit_advice,
    halving,
    step_choice,
)
from plumbob.reports.view.audit.page import answer_rows, audit_answer, card_lines, to_do_text
from plumbob.tests.audit.scenes_as_models import (
    PENDULUM,
    audit_of,
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


def to_do(found, **changes):
    """The advice of an audit as text, with some of its fields replaced."""
    advice = replace(audit_advice(found), **changes)
    return to_do_text(found, advice)


def chosen(target, integrator, step, cost, **changes):
    """A choice in place of euler at 10 ms."""
    options = {"timestep": ("0.01", f"{step:g}")}
    if integrator == "rk4":
        options["integrator"] = ("Euler", "RK4")
    values = {"unguarded": False, "limit": None, "passed_over": None, **changes}
    return StepChoice(target, integrator, step, target / 2, cost, options, **values)


def times(value):
    return Ratio(value, 0.9 * value, 1.1 * value)


def test_what_is_advised_depends_on_the_error(found):
    assert 1e-2 < found.error < 0.1
    near = chosen(1e-2, "rk4", 0.005, times(2.0))
    same = chosen(0.1, "euler", 0.02, times(0.5))
    assert to_do(found, better=near, enough=same) == (
        'for 1 cm: in <option> timestep="0.005" in place of 0.01 and integrator="RK4" in place of '
        'Euler (×2 [1.8, 2.2]); enough for 10 cm: in <option> timestep="0.02" in place of 0.01 '
        "(×0.5 [0.45, 0.55])"
    )
    unguarded = to_do(found, better=replace(near, unguarded=True))
    assert 'refsafe="disable"' in unguarded
    assert "at a risk" in unguarded
    assert "in place of Euler;" in to_do(found, better=replace(near, cost=None), enough=same)
    none = {"better": None, "enough": None}
    assert to_do(found, **none) == "no step that was run is reliably nearer"
    assert to_do(found, **none, raised=("geom_solref",)).endswith(
        "; before another step, raise geom_solref to 20 ms in the file"
    )
    assert to_do(found, **none, accurate=True) == "keep the step"
    capped = replace(found.found, own=replace(found.found.own, remarks=("at its cap",)))
    assert "give the solver more iterations" in to_do(replace(found, found=capped))
    ended = replace(found.reference, why=f"{OUT_OF_TIME} at 0.25 s")
    short = replace(found, found=replace(found.found, index=10), reference=ended)
    assert to_do(short, better=near).endswith("2.2]) up to 0.2 s; a larger --budget tells more")
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


@pytest.mark.parametrize(("height", "acts"), [(0.1, True), (5.0, False)])
def test_refsafe_is_advised_only_where_it_changes_the_motion(height, acts):
    """Contacts of 20 ms are softened at a step of 20 ms, which a ball in free fall does not meet,
    and at the own step of 1 ms contacts of 1 ms are."""
    own = own_model(ball(height=height), "ball")
    motion = script(own, duration=0.1, period=0.02)
    assert own.softened(0.02)
    assert own.softens(motion, "euler", 1) == acts
    assert not own.softens(motion, "euler", 20)
    clamped = own_model(ball(height=height, solref=".001 1"), "ball")
    assert clamped.clamped
    assert clamped.clamping_acts(motion) == acts


def run(step, error, cost, integrator="euler"):
    """A run at a step that costs `cost` in a second."""
    ns = cost * step
    costs = Cost(ns, 0.9 * ns, 1.1 * ns, 1.0, 0.0, 5)
    errors = np.array([0.0, error])
    return StepError(integrator, step, 1, errors, "rod", 0.0, cost=costs)


def evidence(found, steps, own, limits=()):
    """Evidence of some runs, up to the end of one control period; the motion is known to 1 µm."""
    known = replace(found.reference, uncertainty=np.array([0.0, 1e-6]))
    runs = replace(found.found, own=own, steps=tuple(steps), index=1)
    largest = tuple(Limit(name, step, confirmed=True) for name, step in limits)
    stability = LargestSteps(largest, (), own.step) if limits else None
    return StepEvidence(found.model, known, runs, stability)


def named(choice):
    """The integrator, the step [s] and the error [m] of a choice."""
    return choice and (choice.integrator, choice.step, choice.error)


def test_a_step_is_cheapest_only_where_every_smaller_one_is_as_good(found):
    steps = [run(4.0, 5e-4, 1.0), run(2.0, 3e-3, 2.0), run(1.0, 8e-4, 4.0), run(0.5, 4e-4, 8.0)]
    best = step_choice(evidence(found, steps, steps[1]), 1e-3)
    assert named(best) == ("euler", 1.0, 8e-4)
    spread = 1.0 + math.hypot(0.1, 0.1)  # of both: independent of each other
    assert (best.cost.low, best.cost.value, best.cost.high) == pytest.approx(
        (2.0 / spread, 2.0, 2.0 * spread)
    )
    over = best.passed_over
    assert (over.step, over.worse, over.limit) == (4.0, (2.0, 3e-3), None)
    assert step_choice(evidence(found, steps[:2], steps[1]), 1e-3) is None
    # The motion is known to a quarter of this error only.
    assert step_choice(evidence(found, steps, steps[1]), 4e-6) is None
    ended = replace(steps[2], cost=None)
    assert named(step_choice(evidence(found, [ended, steps[3]], ended), 1e-3)) == (
        "euler",
        0.5,
        4e-4,
    )


def test_an_error_is_the_largest_of_all_smaller_steps(found):
    """An error that crosses zero at a step is small there by chance."""
    steps = [run(2.0, 1e-5, 1.0), run(1.0, 4e-4, 2.0), run(0.5, 2e-4, 4.0)]
    assert named(step_choice(evidence(found, steps, steps[0]), 1e-3)) == ("euler", 2.0, 4e-4)


@pytest.mark.parametrize("cost", [0.81, 0.99, 1.0, 1.01, 1.24])
def test_where_costs_are_alike_the_choice_is_kept(found, cost):
    """A difference that scatters from call to call decides nothing; a clear one does."""
    own = run(1.0, 8e-4, 1.0)
    best = step_choice(evidence(found, [run(2.0, 8e-4, cost, "rk4"), own], own), 1e-3)
    assert (best.integrator, best.cost) == ("euler", Ratio(1.0, 1.0, 1.0))
    best = step_choice(evidence(found, [run(2.0, 8e-4, 0.79, "rk4"), own], own), 1e-3)
    assert best.integrator == "rk4"


@pytest.mark.parametrize("cost", [1.8, 2.0, 2.2])
def test_no_dominated_step_is_advised(found, cost):
    """Euler at half the step costs twice as much as its own step; RK4 costs as much, and its error
    is a hundredth."""
    own = run(1.0, 5e-2, 1.0)
    steps = [own, run(0.5, 9e-3, 2.0), run(2.0, 9e-5, cost, "rk4")]
    assert named(step_choice(evidence(found, steps, own), 1e-2)) == ("rk4", 2.0, 9e-5)


def test_an_equal_error_is_no_reason_for_another_integrator(found):
    """Costs of equal work scatter by a few per cent, and errors of Euler and implicitfast steps
    differ in the third digit."""
    own = run(1.0, 5e-2, 1.0)
    steps = [own, run(0.5, 9e-3, 2.0), run(0.5, 8.9e-3, 1.95, "implicitfast")]
    assert step_choice(evidence(found, steps, own), 1e-2).integrator == "euler"
    steps[2] = run(0.5, 8.1e-3, 1.95, "implicitfast")
    assert step_choice(evidence(found, steps, own), 1e-2).integrator == "implicitfast"


@pytest.mark.parametrize(("limit", "step"), [(1.09, 0.5), (1.2, 0.5), (1.26, 1.0), (None, 1.0)])
def test_no_step_near_its_limit_is_advised(found, limit, step):
    """A step has to be at most 0.8 of the largest that holds, as `recommend` has it."""
    own = run(1.0, 8e-4, 1.0)
    steps = [own, run(0.5, 4e-4, 2.0)]
    limits = (("euler", limit),) if limit else ()
    best = step_choice(evidence(found, steps, own, limits), 1e-3)
    assert (best.step, best.limit) == (step, limit)
    assert (best.passed_over and best.passed_over.limit) == (limit if step < 1.0 else None)


def test_advice_says_that_the_own_step_is_near_its_limit(found):
    limits = replace(found.stability, limits=(Limit("euler", 0.0109, confirmed=True),))
    assert "the step is within 20 % of the largest that holds along this motion, 10.9 ms" in (
        to_do(replace(found, stability=limits))
    )


def test_a_choice_that_saves_nothing_is_not_enough(found):
    """A cost of 0.75 whose spread reaches 0.825 is no clear saving."""
    known = replace(found.reference, uncertainty=0.0 * found.reference.uncertainty)
    own = found.found.own
    for cost, saves in ((0.75, False), (0.7, True)):
        scaled = replace(own.cost, ns_per_step=cost * own.cost.ns_per_step)
        scaled = replace(scaled, low=scaled.ns_per_step, high=1.1 * scaled.ns_per_step)
        other = replace(own, integrator="implicitfast", cost=scaled)
        exact = replace(own, cost=replace(own.cost, low=own.cost.ns_per_step))
        runs = replace(found.found, own=exact, steps=(exact, other))
        advice = audit_advice(replace(found, found=runs, reference=known))
        assert (advice.enough is not None) == saves


URDF = """<robot name="arm">{more}<link name="base"/>
<link name="rod"><inertial><origin xyz=".25 0 0"/><mass value="1"/>
  <inertia ixx=".001" iyy=".02" izz=".02" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz=".25 0 0"/><geometry><box size=".5 .04 .04"/></geometry></collision></link>
<joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/>
  <axis xyz="0 1 0"/></joint></robot>"""
EXTENDED = '<mujoco><compiler fusestatic="true"/></mujoco>'


@pytest.mark.parametrize("more", ["", EXTENDED])
def test_options_of_a_urdf_go_where_mujoco_reads_them(tmp_path, more):
    """MuJoCo's importer reads options of a URDF in an element <mujoco> inside <robot>, of which
    there may be one."""
    path = tmp_path / "arm.urdf"
    path.write_text(URDF.format(more=more), "utf-8")
    model = ready(path)
    result = audited(model, script(model, duration=0.2), "rest", Allowance(10.0))
    advice = audit_advice(result)
    assert "in <option>" not in to_do_text(result, advice)
    choice = advice.better
    assert choice is not None
    snippet = "\n".join(card_lines(result)[1:])
    if more:
        text = path.read_text("utf-8").replace("<mujoco>", f"<mujoco>{snippet}")
    else:
        text = path.read_text("utf-8").replace("</robot>", f"{snippet}</robot>")
    pasted = mujoco.MjModel.from_xml_string(text)
    assert pasted.opt.timestep == choice.step
    assert pasted.opt.integrator == ("euler", "rk4").index(choice.integrator)


RAMP = """<mujoco><option timestep=".002" {options}/><worldbody>
  <geom name="ramp" type="plane" size="2 2 .1" euler="0 20 0" friction="0.6"/>
  <body name="box" pos="0.0174 0 .0478" euler="0 20 0"><freejoint/>
    <geom name="box" type="box" size=".1 .1 .05" mass="1" friction="0.6"/></body>
</worldbody></mujoco>"""


def test_contacts_that_slide_do_not_drift():
    """A box slides down the ramp at a friction of 0.2, less than the tangent of 20°."""
    text = RAMP.format(options="").replace('"0.6"', '"0.2"')
    model = ready(compiled(text))
    motion = script(model, duration=0.2)
    moving = model.stepped(motion, "euler", 64).states[-1]
    assert model.readings(moving[None])["slip"] > 0.1
    assert model.held_contacts(moving, motion.controls[-1]).drift == 0.0


@pytest.mark.parametrize(
    ("options", "drifts"),
    [('impratio="1"', True), ('impratio="1000" cone="elliptic"', False)],
)
def test_advice_names_the_setting_that_makes_contacts_drift(options, drifts):
    """A box on a ramp of 20° at a friction of 0.6 rests by Coulomb's law. MuJoCo's friction is
    regularised, so that the box drifts, whatever the step; 1000 times the impratio makes it drift
    1000 times as slowly."""
    model = ready(compiled(RAMP.format(options=options)))
    result = audited(model, script(model, duration=0.4), "rest", Allowance(10.0))
    effects = [
        effect for effect in audit_advice(result).model_effects if effect.name == "drift"
    ]
    assert bool(effects) == drifts
    if drifts:
        (effect,) = effects
        finest = result.model.stepped(result.script, "euler", 64).states
        moved = np.linalg.norm(finest[-1, :3] - finest[-2, :3]) / result.script.period
        # The drift is steady to 2 % within the last period of 20 ms.
        assert effect.size == pytest.approx(moved, rel=0.02)
        assert 'the model makes that, by impratio="1"' in to_do(result)


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
    evidence = StepEvidence(own, certified(own, motion, Allowance(20.0)), found, None)
    near = step_choice(evidence, 1e-4)
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


@pytest.mark.parametrize("step", [0.0009, 0.00093, 0.001])
def test_halving_counts_the_own_step_whatever_its_digits(step):
    """n s / n is not the step s to the bit for each s: the own step is known by its number of steps
    in a period."""
    text = PENDULUM.format(integrator="Euler").replace('timestep="0.01"', f'timestep="{step}"')
    audit = audit_of(text, duration=0.3, budget=5.0)
    assert audit.step == pytest.approx(step)
    halved = halving(audit)
    assert (halved.outcome, halved.largest_step) == ("helps", audit.found.own.step)


def test_an_order_is_that_of_errors_that_the_reference_resolves(found):
    """Errors of second order above what is known; below that they go up and down."""
    known = replace(found.reference, uncertainty=np.array([0.0, 1e-6]))
    steps = [run(2.0**-k, 4.0**-k, 1.0) for k in range(8)]
    steps += [run(2.0**-k, 4e-6, 1.0) for k in range(9, 12)]
    order = observed_order(steps, known, 1)
    assert (order.low, order.slope, order.high) == pytest.approx((2.0, 2.0, 2.0))
