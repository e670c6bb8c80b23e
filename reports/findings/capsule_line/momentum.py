"""The finding on momentum: without friction the common centre of mass stays."""

from __future__ import annotations

import numpy as np

from plumbob.engines.trajectory import Trajectory
from plumbob.reports.findings.capsule.cells import method as method_cell
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import problem, run
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number

SCENE, STEP = "capsule-line/frictionless", 1e-3
METHODS = ("mujoco/euler+coulomb", "mujoco/euler", "mujoco/euler+reduced", "pymunk/feet",
           "pymunk/side")  # fmt: skip


def finding() -> Finding | None:
    """How far the common centre of mass goes in each engine, f being zero."""
    found = {name: one for name in METHODS if (one := run(SCENE, name, STEP)) is not None}
    if not found:
        return None
    shifts = {name: _shift(one) for name, one in found.items()}
    gone = abs(problem(SCENE).motion.displacement)
    rows = tuple(row(method_cell(name), value(shift)) for name, shift in shifts.items())
    return Finding(
        "capsule-momentum",
        "The slider's reaction is whole: momentum is conserved",
        "confirmed",
        f"Without friction the body goes back by {number(gone)} m and the common centre of mass by "
        f"no more than {number(max(shifts.values()), 2)} m.",
        (
            "MuJoCo's slider is driven by a joint of large armature, pymunk's by a pivot that "
            "takes hold of the body where the slider will be: in both the reaction on the body is "
            "equal and opposite, on one line.",
        ),
        (Table(f"f = 0, step {number(STEP)} s",
               ("method", "common centre of mass moves by [m]"), rows),),
        (),
        (f"plumbob validate --scenes {SCENE}",),
    )  # fmt: skip


def _shift(found: Trajectory) -> float:
    """Largest way of the common centre of mass along the line [m]: the engine's own, if it says."""
    if "centre_of_mass" in found.channels:
        return float(np.ptp(found.channels["centre_of_mass"]))
    part = problem(SCENE).setup.capsule.mass_ratio
    seen = found.observables
    return float(np.abs(seen["displacement"] + part * seen["stroke"]).max())
