"""Parts that models leave out: heights, the reaction on the slider, and all but one motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan, TrimmingRun
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, at_most, clear
from plumbob.reports.analyses.measurements import (
    LINE,
    covers,
    displacement_error,
    end_error,
    plan_of,
    problem,
    recordings,
    runs,
)
from plumbob.reports.view.notation import short

TILTED, TILTED_STEPS = "capsule-line/at-123", (1e-3, 1e-4)  # [s]
LOW, TALL = "mujoco/euler+coulomb", "mujoco/euler+tall"
LOAD = "normal_force_2"
FREE, FREE_STEP = "capsule-line/frictionless", 1e-3
FREE_METHODS = (
    "mujoco/euler+coulomb",
    "mujoco/euler",
    "mujoco/euler+reduced",
    "pymunk/feet",
    "pymunk/side",
)
KEPT = 1e-3  # of the body's path: how far the common centre of mass may go
CHEAPER = 0.9  # of a cost: more is the scatter of timings
HARDLY = 1e-2  # of a displacement: a negligible change
PAIRS = (
    ("mujoco/euler+coulomb", "mujoco/euler+reduced"),
    ("mujoco/rk4+coulomb", "mujoco/rk4+reduced"),
)
SAVING_STEP = 1e-4  # [s]
TIMED_STEPS, REPEATS = 300, 7  # the push, so often
HEIGHT_RUNS = runs((TILTED,), (LOW, TALL), TILTED_STEPS)
FREE_RUNS = runs((FREE,), FREE_METHODS, (FREE_STEP,))


def saving_requests(plan: StudyPlan) -> Sequence[Request[Any]]:
    """Runs of both models; both timed where the study does not time them."""
    pairs = _pairs(plan.profile)
    return (
        *runs((LINE,), [name for pair in pairs for name in pair], (SAVING_STEP,)),
        *(_timing(name) for pair in pairs if not _timed_by(plan, pair) for name in pair),
    )


def heights(study: Study) -> Record | None:
    """Loads and displacement of a capsule whose C and Q are above the plane."""
    by_request = recordings(study, HEIGHT_RUNS)
    if len(by_request) < len(HEIGHT_RUNS):
        return None
    every = tuple(_height_run(request, run) for request, run in by_request.items())
    low, fine_low, tall, fine_tall = every
    posed, height = problem(TILTED), float(find_method(TALL).settings["height"])
    times = np.linspace(0.0, float(low.times[-1]), 200)
    return Record(
        height=height,  # [m]
        # [N m], of friction while the body slides
        moment=posed.setup.capsule.friction * posed.setup.capsule.weight * height,
        runs=every,  # in the plane at both steps, above it at both
        # [N], the largest change of the load at A2 at the coarse step
        shift=np.abs(tall.loads - low.loads).max(),
        # of the displacement at both steps, relative
        changes=(
            abs(tall.error - low.error),
            abs(fine_tall.error - fine_low.error),
        ),
        times=times,  # [s]
        statics=posed.reference.observe(times)[LOAD],  # [N] at A2, without heights
    )


def _height_run(request: ExtraRun, run: Trajectory) -> Record:
    """A run of a capsule with or without heights."""
    return Record(
        method=request.method,
        step=request.step,  # [s]
        error=end_error(TILTED, run),  # of the displacement, relative
        largest_heading=np.abs(run.observables["heading"]).max(),  # [rad]
        times=run.times,  # [s]
        loads=run.observables[LOAD],  # [N], at A2
    )


def _unchanged(numbers: Record) -> Claims:
    text = f"the change of Δx at {short(TILTED_STEPS[1])} s, relative,"
    return (
        at_most(text, numbers.changes[1], HARDLY),
        clear("the shift of N₂, and a thousandth of a newton", numbers.shift, 1e-3, "N"),
    )


def momentum(study: Study) -> Record | None:
    """How far the common centre of mass goes in each engine without friction."""
    by_request = recordings(study, FREE_RUNS)
    shifts = {request.method: _shift(run) for request, run in by_request.items()}
    travelled = abs(float(problem(FREE).motion.displacement))
    return (
        Record(
            shifts=shifts,
            largest=max(shifts.values()),
            travelled=travelled,  # [m], by the body
            step=FREE_STEP,
        )
        if shifts
        else None
    )


def _shift(run: Trajectory) -> float:
    """Largest displacement of the common centre of mass along the line [m]: the engine's own, where
    it gives that."""
    if "centre_of_mass" in run.channels:
        return float(np.ptp(run.channels["centre_of_mass"]))
    fraction = problem(FREE).setup.capsule.mass_ratio
    observables = run.observables
    return float(np.abs(observables["displacement"] + fraction * observables["stroke"]).max())


def _conserved(numbers: Record) -> Claims:
    text = "the way of the common centre of mass, over the body's,"
    return (at_most(text, numbers.largest / numbers.travelled, KEPT),)


def saving(study: Study) -> Record | None:
    """Costs of a step of the full and of the reduced model, whose motion is the same."""
    costs = [
        Record(
            method=name,
            cost=cost,
            relative=cost / known[0],
            error=displacement_error(study, LINE, name, SAVING_STEP),
        )
        for pair in _pairs(study.profile)
        if (known := _costs(study, pair))
        for name, cost in zip(pair, known, strict=True)
    ]
    return (
        Record(
            costs=costs,
            part=costs[1].relative,  # of the first full model's cost
            saved=1.0 - costs[1].relative,
            step=SAVING_STEP,
        )
        if costs
        else None
    )


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
        trimmed = [study.answer(_timing(name)) for name in pair]
        costs = [trimming.ns_trimmed for trimming in trimmed if trimming]
    return (costs[0], costs[1]) if len(costs) == len(pair) else None


def _cheaper(numbers: Record) -> Claims:
    return (at_most("the cost of a reduced step, over a full one,", numbers.part, CHEAPER),)


HEIGHTS = Analysis("capsule_line/heights", heights, lambda plan: HEIGHT_RUNS, _unchanged)
MOMENTUM = Analysis("capsule_line/momentum", momentum, lambda plan: FREE_RUNS, _conserved)
SAVING = Analysis("capsule_line/saving", saving, saving_requests, _cheaper)
