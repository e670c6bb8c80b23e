"""Parts that models leave out: heights, the reaction on the slider, and all but one motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.extra_runs import ExtraRun, Request, StudyPlan, TrimmingRun
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis
from plumbob.reports.analyses.claims import at_most, clear
from plumbob.reports.analyses.measurements import (
    LINE,
    covers,
    displacement_error,
    plan_of,
    problem,
    runs,
)
from plumbob.reports.view.content import Claim
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
    coarse: tuple[HeightRun, HeightRun]  # in the plane, above it
    fine: tuple[HeightRun, HeightRun]
    times: Array  # [s]
    statics: Array  # [N] at A2, without heights

    @property
    def shift(self) -> float:
        """The largest change of the load at A2 [N], at the coarse step."""
        low, tall = self.coarse
        return float(np.abs(tall.loads - low.loads).max())

    @property
    def change(self) -> float:
        """The change of the displacement at the coarse step, relative."""
        low, tall = self.coarse
        return abs(tall.error - low.error)

    @property
    def fine_change(self) -> float:
        """The same at the fine step."""
        low, tall = self.fine
        return abs(tall.error - low.error)


@dataclass(frozen=True)
class Momentum:
    """How far the common centre of mass goes in each engine without friction [m]."""

    shifts: Mapping[str, float]
    travelled: float  # [m], by the body
    step: float = FREE_STEP

    @property
    def largest(self) -> float:
        """The largest of the shifts."""
        return max(self.shifts.values())


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
    cost: float  # of the first reduced model, in % of the full one
    step: float = SAVING_STEP

    @property
    def saved(self) -> float:
        """The part of the cost that is saved [%]."""
        return 100.0 - self.cost


def height_requests(plan: StudyPlan) -> Sequence[Request]:
    """Runs with and without height."""
    return runs((TILTED,), (LOW, TALL), TILTED_STEPS)


def momentum_requests(plan: StudyPlan) -> Sequence[Request]:
    """Runs without friction."""
    return runs((FREE,), FREE_METHODS, (FREE_STEP,))


def saving_requests(plan: StudyPlan) -> Sequence[Request]:
    """Runs of both models; both timed where the study does not time them."""
    pairs = _pairs(plan.profile)
    return (
        *runs((LINE,), [name for pair in pairs for name in pair], (SAVING_STEP,)),
        *(_timing(name) for pair in pairs if not _timed_by(plan, pair) for name in pair),
    )


def heights(study: Study) -> Heights | None:
    """Loads and displacement of a capsule whose C and Q are above the plane."""
    every = [_height_run(study, name, step) for step in TILTED_STEPS for name in (LOW, TALL)]
    known = [run for run in every if run is not None]
    if len(known) < len(every):
        return None
    low, tall, fine_low, fine_tall = known
    posed, height = problem(TILTED), float(find_method(TALL).settings["height"])
    body = posed.setup.capsule
    times = np.linspace(0.0, float(low.times[-1]), 200)
    return Heights(
        height=height,
        moment=body.friction * body.weight * height,
        coarse=(low, tall),
        fine=(fine_low, fine_tall),
        times=times,
        statics=posed.reference.observe(times)[LOAD],
    )


def _height_run(study: Study, method: str, step: float) -> HeightRun | None:
    run = study.recording(ExtraRun(TILTED, method, step))
    error = displacement_error(study, TILTED, method, step)
    if run is None or error is None:
        return None
    heading = float(np.abs(run.observables["heading"]).max())
    return HeightRun(method, step, error, heading, run.times, run.observables[LOAD])


def _unchanged(numbers: Heights) -> Sequence[Claim]:
    text = f"the change of Δx at {short(numbers.fine[0].step)} s, relative,"
    return (
        at_most(text, numbers.fine_change, HARDLY),
        clear("the shift of N₂, and a thousandth of a newton", numbers.shift, 1e-3, "N"),
    )


def momentum(study: Study) -> Momentum | None:
    """How far the common centre of mass goes in each engine without friction."""
    recorded = {name: study.recording(ExtraRun(FREE, name, FREE_STEP)) for name in FREE_METHODS}
    shifts = {name: _shift(run) for name, run in recorded.items() if run is not None}
    travelled = abs(float(problem(FREE).motion.displacement))
    return Momentum(shifts, travelled) if shifts else None


def _shift(run: Trajectory) -> float:
    """Largest displacement of the common centre of mass along the line [m]: the engine's own, where
    it gives that."""
    if "centre_of_mass" in run.channels:
        return float(np.ptp(run.channels["centre_of_mass"]))
    fraction = problem(FREE).setup.capsule.mass_ratio
    observables = run.observables
    return float(np.abs(observables["displacement"] + fraction * observables["stroke"]).max())


def _conserved(numbers: Momentum) -> Sequence[Claim]:
    text = "the way of the common centre of mass, over the body's,"
    return (at_most(text, numbers.largest / numbers.travelled, KEPT),)


def saving(study: Study) -> Saving | None:
    """Costs of a step of the full and of the reduced model, whose motion is the same."""
    costs = [
        StepCost(name, cost, cost / known[0], displacement_error(study, LINE, name, SAVING_STEP))
        for pair in _pairs(study.profile)
        if (known := _costs(study, pair)) is not None
        for name, cost in zip(pair, known, strict=True)
    ]
    return Saving(tuple(costs), 100.0 * costs[1].cost / costs[0].cost) if costs else None


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


def _cheaper(numbers: Saving) -> Sequence[Claim]:
    return (at_most("the cost of a reduced step, over a full one,", numbers.cost / 100.0, CHEAPER),)


HEIGHTS = Analysis("capsule_line/heights", heights, height_requests, _unchanged)
MOMENTUM = Analysis("capsule_line/momentum", momentum, momentum_requests, _conserved)
SAVING = Analysis("capsule_line/saving", saving, saving_requests, _cheaper)
