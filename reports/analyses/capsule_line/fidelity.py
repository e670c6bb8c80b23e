"""Effects of simplified models: the height of the masses, and the momentum without friction."""

from __future__ import annotations

import numpy as np

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, at_most, clearly_larger
from plumbob.reports.analyses.measurements import (
    end_error,
    extra_runs,
    problem,
    recordings,
)
from plumbob.reports.records.notation import short

TILTED_SCENE = "capsule-line/at-123"
TILTED_STEPS = (1e-3, 1e-4)  # [s]
LOW, TALL = "mujoco/euler+coulomb", "mujoco/euler+tall"
LOAD = "normal_force_2"
FRICTIONLESS_SCENE, FREE_STEP = "capsule-line/frictionless", 1e-3  # [s]
FREE_METHODS = (
    "mujoco/euler+coulomb",
    "mujoco/euler",
    "mujoco/euler+reduced",
    "pymunk/feet",
    "pymunk/side",
)
# largest displacement of the common centre of mass, relative to the body's
CENTRE_OF_MASS_DRIFT = 1e-3
NEGLIGIBLE_CHANGE = 1e-2  # largest relative change of a displacement that is negligible
HEIGHT_RUNS = extra_runs((TILTED_SCENE,), (LOW, TALL), TILTED_STEPS)
FREE_RUNS = extra_runs((FRICTIONLESS_SCENE,), FREE_METHODS, (FREE_STEP,))


def heights(study: Study) -> Record | None:
    """Returns the changes of load and displacement if the masses C and Q are above the plane; None
    if a run is missing."""
    by_request = recordings(study, HEIGHT_RUNS)
    if len(by_request) < len(HEIGHT_RUNS):
        return None
    low, fine_low, tall, fine_tall = by_request.values()
    pairs = ((low, tall), (fine_low, fine_tall))
    capsule = problem(TILTED_SCENE).setup.capsule
    height = float(find_method(TALL).settings["height"])
    return Record(
        height=height,  # [m]
        # [N m] moment of friction while the body slides
        moment=capsule.friction * capsule.weight * height,
        steps=TILTED_STEPS,
        # [N] largest change of the load at A2, at the coarse step
        shift=np.abs(tall.observables[LOAD] - low.observables[LOAD]).max(),
        # relative changes of the displacement at both steps
        changes=[
            abs(end_error(TILTED_SCENE, b) - end_error(TILTED_SCENE, a)) for a, b in pairs
        ],
    )


def _unchanged(numbers: Record) -> Claims:
    """Returns the checks that the height shifts a load and hardly changes the displacement."""
    text = f"the change of Δx at {short(TILTED_STEPS[1])} s, relative,"
    return (
        at_most(text, numbers.changes[1], NEGLIGIBLE_CHANGE),
        clearly_larger(
            "the shift of N₂, and a thousandth of a newton", numbers.shift, 1e-3, "N"
        ),
    )


def momentum(study: Study) -> Record | None:
    """Returns the displacement of the common centre of mass in each engine without friction; None
    if no engine ran."""
    by_request = recordings(study, FREE_RUNS)
    shifts = {request.method: _shift(run) for request, run in by_request.items()}
    if not shifts:
        return None
    return Record(
        shifts=shifts,
        largest=max(shifts.values()),
        # [m] exact displacement of the body
        travelled=abs(float(problem(FRICTIONLESS_SCENE).motion.displacement)),
        step=FREE_STEP,
    )


def _shift(run: Trajectory) -> float:
    """Returns the largest displacement of the common centre of mass along the line [m]. If the
    engine records the centre of mass, its record is used."""
    if "centre_of_mass" in run.channels:
        return float(np.ptp(run.channels["centre_of_mass"]))
    fraction = problem(FRICTIONLESS_SCENE).setup.capsule.mass_ratio
    observables = run.observables
    return float(np.abs(observables["displacement"] + fraction * observables["stroke"]).max())


def _conserved(numbers: Record) -> Claims:
    """Returns the check that the common centre of mass hardly moves without friction."""
    text = "the way of the common centre of mass, over the body's,"
    return (at_most(text, numbers.largest / numbers.travelled, CENTRE_OF_MASS_DRIFT),)


HEIGHTS = Analysis("capsule_line/heights", heights, lambda plan: HEIGHT_RUNS, _unchanged)
MOMENTUM_FINDING = Analysis(
    "capsule_line/momentum", momentum, lambda plan: FREE_RUNS, _conserved
)
