"""Parts that models leave out: heights, the reaction on the slider, and all but one motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan, TrimmingRun
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis
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


@dataclass(frozen=True)
class HeightRun:
    """A run of a capsule with or without heights."""

    method: str
    step: float  # [s]
    error: float  # of the displacement, relative
    largest_heading: float  # [rad]
    times: Array  # [s]
    loads: Array  # [N], at A2


@dataclass(frozen=True)
class Heights:
    """Loads and displacement of a capsule whose C and Q are above the plane, and in it."""

    height: float  # [m]
    moment: float  # [N m], of friction while the body slides
    runs: tuple[HeightRun, ...]  # in the plane at both steps, above it at both
    shift: float  # [N], the largest change of the load at A2 at the coarse step
    changes: tuple[float, float]  # of the displacement at both steps, relative
    times: Array  # [s]
    statics: Array  # [N] at A2, without heights


@dataclass(frozen=True)
class Momentum:
    """How far the common centre of mass goes in each engine without friction [m]."""

    shifts: Mapping[str, float]
    largest: float
    travelled: float  # [m], by the body
    step: float = FREE_STEP


@dataclass(frozen=True)
class StepCost:
    """The cost of a method's step [ns], over that of the full model, and its relative error."""

    method: str
    cost: float
    relative: float
    error: float | None


@dataclass(frozen=True)
class Saving:
    """Costs of the full and of the reduced model, whose motion is the same."""

    costs: tuple[StepCost, ...]
    part: float  # of the first full model's cost
    saved: float
    step: float = SAVING_STEP


def saving_requests(plan: StudyPlan) -> Sequence[Request[Any]]:
    """Runs of both models; both timed where the study does not time them."""
    pairs = _pairs(plan.profile)
    return (
        *runs((LINE,), [name for pair in pairs for name in pair], (SAVING_STEP,)),
        *(_timing(name) for pair in pairs if not _timed_by(plan, pair) for name in pair),
    )


def heights(study: Study) -> Heights | None:
    """Loads and displacement of a capsule whose C and Q are above the plane."""
    by_request = recordings(study, HEIGHT_RUNS)
    if len(by_request) < len(HEIGHT_RUNS):
        return None
    every = tuple(_height_run(request, run) for request, run in by_request.items())
    low, fine_low, tall, fine_tall = every
    posed, height = problem(TILTED), float(find_method(TALL).settings["height"])
    times = np.linspace(0.0, float(low.times[-1]), 200)
    return Heights(
        height,
        posed.setup.capsule.friction * posed.setup.capsule.weight * height,
        every,
        float(np.abs(tall.loads - low.loads).max()),
        (abs(tall.error - low.error), abs(fine_tall.error - fine_low.error)),
        times,
        posed.reference.observe(times)[LOAD],
    )


def _height_run(request: ExtraRun, run: Trajectory) -> HeightRun:
    return HeightRun(
        request.method,
        request.step,
        end_error(TILTED, run),
        float(np.abs(run.observables["heading"]).max()),
        run.times,
        run.observables[LOAD],
    )


def _unchanged(numbers: Heights) -> Claims:
    text = f"the change of Δx at {short(TILTED_STEPS[1])} s, relative,"
    return (
        at_most(text, numbers.changes[1], HARDLY),
        clear("the shift of N₂, and a thousandth of a newton", numbers.shift, 1e-3, "N"),
    )


def momentum(study: Study) -> Momentum | None:
    """How far the common centre of mass goes in each engine without friction."""
    by_request = recordings(study, FREE_RUNS)
    shifts = {request.method: _shift(run) for request, run in by_request.items()}
    travelled = abs(float(problem(FREE).motion.displacement))
    return Momentum(shifts, max(shifts.values()), travelled) if shifts else None


def _shift(run: Trajectory) -> float:
    """Largest displacement of the common centre of mass along the line [m]: the engine's own, where
    it gives that."""
    if "centre_of_mass" in run.channels:
        return float(np.ptp(run.channels["centre_of_mass"]))
    fraction = problem(FREE).setup.capsule.mass_ratio
    observables = run.observables
    return float(np.abs(observables["displacement"] + fraction * observables["stroke"]).max())


def _conserved(numbers: Momentum) -> Claims:
    text = "the way of the common centre of mass, over the body's,"
    return (at_most(text, numbers.largest / numbers.travelled, KEPT),)


def saving(study: Study) -> Saving | None:
    """Costs of a step of the full and of the reduced model, whose motion is the same."""
    costs = [
        StepCost(name, cost, cost / known[0], displacement_error(study, LINE, name, SAVING_STEP))
        for pair in _pairs(study.profile)
        if (known := _costs(study, pair))
        for name, cost in zip(pair, known, strict=True)
    ]
    return Saving(tuple(costs), costs[1].relative, 1.0 - costs[1].relative) if costs else None


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


def _cheaper(numbers: Saving) -> Claims:
    return (at_most("the cost of a reduced step, over a full one,", numbers.part, CHEAPER),)


HEIGHTS = Analysis("capsule_line/heights", heights, lambda plan: HEIGHT_RUNS, _unchanged)
MOMENTUM = Analysis("capsule_line/momentum", momentum, lambda plan: FREE_RUNS, _conserved)
SAVING = Analysis("capsule_line/saving", saving, saving_requests, _cheaper)
