"""The page's section on the capsule coasting to rest: the step's lead in the stopping distance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from analytic.reference import StepReference
from engines.registry import method as find_method
from engines.study import Study
from models.scene import Scene
from reports.content import Cell, Figure, Finding, Section, Table, row
from reports.notation import number, short
from reports.sections.capsule.cells import method as method_cell
from reports.sections.capsule.cells import value
from reports.sections.capsule.runs import problem, run

SCENE = "capsule-coast/translation"
METHODS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk/feet",
           "pymunk/side")  # fmt: skip
STEPS = (1e-3, 1e-4)


def findings(study: Study) -> Sequence[Finding]:
    """Error of the stopping distance over v0 dt/2, in both engines."""
    posed = problem(SCENE)
    reference = posed.reference
    assert isinstance(reference, StepReference)
    speed = math.hypot(*posed.staging.velocity)
    distance = float(posed.motion.coasting.distance)
    rows = []
    for name in METHODS:
        cells: list[Cell] = []
        for step in STEPS:
            if (found := run(SCENE, name, step)) is None:
                break
            gone = np.hypot(found.observables["x"][-1], found.observables["y"][-1])
            told = reference.foretold(find_method(name).scheme, step, found.times)
            lead = math.copysign(math.hypot(told["x"][-1], told["y"][-1]), told["x"][-1])
            half = 0.5 * speed * step
            cells += [value((gone - distance) / half, 4), value(lead / half, 4)]
        if len(cells) == 2 * len(STEPS):
            rows.append(row(method_cell(name), *cells))
    if not rows:
        return ()
    heads = ("method", *(
        f"{what}, step {short(step)} s" for step in STEPS for what in ("measured", "foretold")
    ))  # fmt: skip
    return (
        Finding(
            "capsule-stopping-distance",
            "Two engines stop short and too far by the same half step",
            "confirmed",
            f"A body at {number(speed)} m/s stops after v₀²/(2fg) = {number(distance)} m wherever "
            "its slider sits. MuJoCo, which changes velocities first, falls short by v₀dt/2; "
            "pymunk, which moves first, goes too far by it.",
            (
                "The coefficient is exact but for what the last step leaves, a sawtooth of second "
                "order, and is judged, not bounded. Default contacts add what hopping costs.",
            ),
            (Table("Error of the stopping distance over v₀dt/2", heads, tuple(rows)),),
            (),
            (f"plumbob run {SCENE} mujoco/euler+coulomb --step 1e-4",
             f"plumbob run {SCENE} pymunk/feet --step 1e-4"),
        ),
    )  # fmt: skip


def _figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    return ()


def _hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    return ()


SECTION = Section(findings, _figures, _hard)
