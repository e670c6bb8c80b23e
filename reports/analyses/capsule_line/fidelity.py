"""Findings on what models leave out: heights, the reaction on the slider, and the reduced model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.extra_runs import ExtraRun, Request, StudyPlan, TrimmingRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.claims import at_most, clear
from plumbob.reports.analyses.measurements import (
    LINE,
    covers,
    displacement_error,
    plan_of,
    problem,
    runs,
)
from plumbob.reports.view.content import (
    Cell,
    Finding,
    Statement,
    Table,
    method_cell,
    plain_method_cell,
    row,
    value,
)
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import GREY, OF_METHODS
from plumbob.reports.view.sources import CHERNOUSKO
from plumbob.reports.view.traces import Trace, curve, linear, over_time

TILTED, TILTED_STEPS = "capsule-line/at-123", (1e-3, 1e-4)  # [s]
LOW, TALL = "mujoco/euler+coulomb", "mujoco/euler+tall"
LOAD = "normal_force_2"
FREE, FREE_STEP = "capsule-line/frictionless", 1e-3
FREE_METHODS = ("mujoco/euler+coulomb", "mujoco/euler", "mujoco/euler+reduced", "pymunk/feet",
                "pymunk/side")  # fmt: skip
FULL, REDUCED = "mujoco/euler+coulomb", "mujoco/euler+reduced"
KEPT = 1e-3  # of the body's path: how far the common centre of mass may go
CHEAPER = 0.9  # of a cost: more is the scatter of timings
HARDLY = 1e-2  # of a displacement: a negligible change
PAIRS = ((FULL, REDUCED), ("mujoco/rk4+coulomb", "mujoco/rk4+reduced"))
SAVING_STEP = 1e-4  # [s]
TIMED_STEPS, REPEATS = 300, 7  # the push, so often


def requests(plan: StudyPlan) -> Sequence[Request]:
    """Runs with and without height, without friction, and of both models; both timed where the
    study does not time them."""
    pairs = _pairs(plan.profile)
    return (
        *runs((TILTED,), (LOW, TALL), TILTED_STEPS),
        *runs((FREE,), FREE_METHODS, (FREE_STEP,)),
        *runs((LINE,), [name for pair in pairs for name in pair], (SAVING_STEP,)),
        *(_timing(name) for pair in pairs if not _timed_by(plan, pair) for name in pair),
    )


def heights(study: Study) -> Finding | None:
    """Loads and displacement of a capsule whose C and Q are above the plane."""
    runs = {
        (name, step): run
        for name in (LOW, TALL)
        for step in TILTED_STEPS
        if (run := study.recording(ExtraRun(TILTED, name, step))) is not None
    }
    if len(runs) < 2 * len(TILTED_STEPS):
        return None
    posed, (coarse, fine) = problem(TILTED), TILTED_STEPS
    height = float(find_method(TALL).settings["height"])
    moment = posed.setup.capsule.friction * posed.setup.capsule.weight * height
    low, tall = runs[LOW, coarse], runs[TALL, coarse]
    times = np.linspace(0.0, float(low.times[-1]), 200)
    statics = posed.reference.observe(times)[LOAD]
    traces: list[Trace] = [
        curve(times, statics, colour=GREY, width=2.2, name="statics, no height"),
        *(curve(run.times, run.observables[LOAD], colour=OF_METHODS[name], name=name)
          for name, run in ((LOW, low), (TALL, tall))),
    ]  # fmt: skip
    shift = float(np.abs(tall.observables[LOAD] - low.observables[LOAD]).max())
    rows, change = [], {}
    for step in TILTED_STEPS:
        ends = {name: displacement_error(study, TILTED, name, step) or 0.0 for name in (LOW, TALL)}
        change[step] = abs(ends[TALL] - ends[LOW])
        for name, end in ends.items():
            observables = runs[name, step].observables
            load, turn = observables[LOAD], np.abs(observables["heading"])
            cells = (end, float(turn.max()), float(load.min()), float(load.max()))
            rows.append(row(plain_method_cell(name), Cell(short(step), "number"),
                            *map(value, cells)))  # fmt: skip
    heads = ("method", "step [s]", "relative error of Δx", "largest |heading| [rad]",
             "smallest N₂ [N]", "largest N₂ [N]")  # fmt: skip
    return Finding(
        "capsule-heights",
        "Heights shift the loads and leave the motion unchanged",
        "measured",
        "A model of this kind may leave heights out: they shift loads between the feet and "
        "hardly change the motion. "
        f"With C and the slider {number(100 * height)} cm above the plane N₂ changes by up to "
        f"{number(shift, 2)} N, and Δx by {number(100 * change[coarse], 2)} % at a step of "
        f"{short(coarse)} s, {number(100 * change[fine], 2)} % at {short(fine)} s.",
        (
            f"Friction acts a height h below the combined centre of mass. While the body slides, "
            f"its moment is f (M+m) g h = {number(moment)} N m; while friction holds the body, it "
            "is m w₂ h in the opposite direction. That moves load along the line and not across "
            "it, so friction still has no moment about C, and its sum is f times the weight "
            "however the load is distributed. The remaining change of Δx comes from the contacts' "
            "oscillation as the moment appears and disappears, and goes with the step. The limit "
            "is reached when a support lifts off.",
        ),
        (Table(TILTED.partition("/")[2], heads, tuple(rows)),),
        (over_time("Normal force at A₂", f"At a step of {number(coarse)} s.", traces,
                   linear("N₂ [N]"), wide=True),),
        (f"plumbob run {TILTED} {TALL} --step 1e-3",),
        (
            Statement(
                CHERNOUSKO,
                "assumptions",
                "C and Q are in the plane of the supports",
                "heights of zero",
                f"{number(100 * height)} cm above it N₂ changes by up to {number(shift, 2)} N, Δx "
                f"by {number(100 * change[fine], 2)} % at {short(fine)} s",
                "extended",
            ),
        ),
        claims=(
            at_most(f"the change of Δx at {short(fine)} s, relative,", change[fine], HARDLY),
            clear("the shift of N₂, and a thousandth of a newton", shift, 1e-3, "N"),
        ),
    )  # fmt: skip


def momentum(study: Study) -> Finding | None:
    """How far the common centre of mass goes in each engine without friction."""
    runs = {name: study.recording(ExtraRun(FREE, name, FREE_STEP)) for name in FREE_METHODS}
    shifts = {name: _shift(run) for name, run in runs.items() if run is not None}
    if not shifts:
        return None
    travelled = abs(problem(FREE).motion.displacement)
    rows = tuple(row(method_cell(name), value(shift)) for name, shift in shifts.items())
    return Finding(
        "capsule-momentum",
        "The slider's reaction on the body is complete: momentum is conserved",
        "confirmed",
        "The engines lose no momentum between actuator and body. "
        f"Without friction the body goes back by {number(travelled)} m and the common centre of "
        f"mass by no more than {number(max(shifts.values()), 2)} m.",
        (
            "MuJoCo's slider is driven by a joint of large armature, pymunk's by a pivot joint "
            "attached to the body where the slider will be at the end of the step: in both, the "
            "reaction on the body is equal and opposite, along one line.",
        ),
        (Table(f"f = 0, step {number(FREE_STEP)} s",
               ("method", "common centre of mass moves by [m]"), rows),),
        (),
        (f"plumbob validate --scenes {FREE}",),
        claims=(
            at_most("the way of the common centre of mass, over the body's,",
                    max(shifts.values()) / travelled, KEPT),
        ),
    )  # fmt: skip


def _shift(run: Trajectory) -> float:
    """Largest displacement of the common centre of mass along the line [m]: the engine's own, where
    it gives that."""
    if "centre_of_mass" in run.channels:
        return float(np.ptp(run.channels["centre_of_mass"]))
    fraction = problem(FREE).setup.capsule.mass_ratio
    observables = run.observables
    return float(np.abs(observables["displacement"] + fraction * observables["stroke"]).max())


def saving(study: Study) -> Finding | None:
    """Costs of a step of the full and of the reduced model, whose motion is the same."""
    costs = {pair: _costs(study, pair) for pair in _pairs(study.profile)}
    known_costs = {pair: cost for pair, cost in costs.items() if cost is not None}
    if not known_costs:
        return None
    rows = [
        row(method_cell(name), value(ns), value(ns / cost[0] if name == pair[1] else 1.0),
            value(displacement_error(study, LINE, name, SAVING_STEP)))
        for pair, cost in known_costs.items()
        for name, ns in zip(pair, cost, strict=True)
    ]  # fmt: skip
    full, reduced = next(iter(known_costs.values()))
    percentage = 100 * reduced / full
    heads = ("method", "ns per step", "relative to the full model", "relative error of Δx")
    return Finding(
        "capsule-saving",
        "On a line the reduced model gives the same motion at a lower cost",
        "measured",
        "For motions on one line a sliding joint with friction loss replaces all contacts, at "
        "a lower cost. "
        f"A step of the reduced model costs {number(percentage, 2)} % of a step of the full one: "
        f"it saves {number(100 - percentage, 2)} %.",
        (
            "Along one line the body has one degree of freedom, and Σ f Nᵢ is f (M+m) g: a sliding "
            "joint with friction loss replaces a free joint and three contacts. The reduced model "
            "has no heading, no normal forces and no vertical displacement, so it cannot show "
            "that any of them is wrong.",
        ),
        (Table(f"Cost of ca1, and its error at {short(SAVING_STEP)} s", heads, tuple(rows)),),
        (),
        (f"plumbob validate --scenes {LINE} --methods {FULL},{REDUCED}",),
        claims=(
            at_most("the cost of a reduced step, over a full one,", reduced / full, CHEAPER),
        ),
    )  # fmt: skip


def _pairs(profile: str) -> tuple[tuple[str, str], ...]:
    return PAIRS if profile == "full" else PAIRS[:1]


def _timing(method: str) -> TrimmingRun:
    return TrimmingRun(LINE, method, SAVING_STEP, TIMED_STEPS, REPEATS)


def _timed_by(plan: StudyPlan, pair: tuple[str, str]) -> bool:
    """Whether a study times both models itself."""
    return covers(plan, LINE) and set(pair) <= {method.name for method in plan.methods}


def _costs(study: Study, pair: tuple[str, str]) -> tuple[float, float] | None:
    """Cost of a step of the full and of the reduced model [ns]; None where one was not timed."""
    if _timed_by(plan_of(study), pair):
        timed = [study.costs.get((LINE, name)) for name in pair]
        costs = [cost.ns_per_step for cost in timed if cost]
    else:
        trimmed = [study.trimming_of(_timing(name)) for name in pair]
        costs = [trimming.ns_trimmed for trimming in trimmed if trimming]
    return (costs[0], costs[1]) if len(costs) == len(pair) else None
