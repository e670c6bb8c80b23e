"""The finding on a body without symmetry: a product of inertia, and a pivot anywhere in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbob.engines.study.extra_runs import Changes, ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.claims import clear
from plumbob.reports.analyses.cone_pendulum.hamiltonian import (
    END,
    LAGRANGE,
    LAGRANGE_RTOL,
    MUJOCO,
    MUJOCO_STEP,
    ROTATING,
)
from plumbob.reports.view.content import Cell, Finding, Statement, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.sources import SUDAKOV

PRODUCT = 0.029  # [kg m^2]: no body with the cone's other moments has more than 0.0294
TILTED: Changes = (("inertia_yz", PRODUCT),)
MOVED: Changes = (*TILTED, ("pivot_x", 0.5), ("pivot_z", -0.7))  # [m]


@dataclass(frozen=True)
class _Row:
    """A run of a method, and what it is a run of."""

    text: str
    request: ExtraRun


def _rows() -> tuple[_Row, ...]:
    def run(method: str, step: float, changes: Changes) -> ExtraRun:
        return ExtraRun(ROTATING, method, step, END, changes)

    return (
        _Row("MuJoCo's full model", run(MUJOCO, MUJOCO_STEP, TILTED)),
        _Row("the equation in θ, integrated", run(LAGRANGE, LAGRANGE_RTOL, TILTED)),
        _Row("MuJoCo, the pivot at X = 0.5 m, Z = –0.7 m", run(MUJOCO, MUJOCO_STEP, MOVED)),
    )


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """MuJoCo and an integrated equation with a product of inertia, and with the pivot moved."""
    return tuple(line.request for line in _rows())


def finding(study: Study) -> Finding:
    """The closed form in tilted axes against engines that do not use such axes."""
    problem = case_of(find_scene(ROTATING, dict(TILTED))).problem
    upright = replace(problem, body=replace(problem.body, inertia_yz=0.0))
    at = np.array([END])
    exact, without = (float(p.reference.state(at)[0][0]) for p in (problem, upright))
    rows = [
        row("closed form, principal axes tilted", _digits(exact), value(0.0)),
        row("closed form without the product of inertia", _digits(without), value(without - exact)),
    ]
    ends = {}
    for line in _rows():
        run = study.recording(line.request)
        if run is not None:
            ends[line.text] = float(run.observables["theta"][-1])
            rows.append(row(line.text, _digits(ends[line.text]), value(ends[line.text] - exact)))
    worst = max((abs(end - exact) for end in ends.values()), default=0.0)
    moved = abs(exact - without)
    still, elsewhere = (ends.get(line.text) for line in _rows()[::2])
    carried = None if still is None or elsewhere is None else abs(elsewhere - still)
    return Finding(
        "no-symmetry",
        "A body without any symmetry has the same three-term potential, in tilted axes",
        "extended",
        "The closed form also serves bodies without symmetry, if angles are measured from the "
        "principal axes. "
        f"A product of inertia of {number(PRODUCT)} kg m² moves θ({END} s) by {number(moved)} rad. "
        f"Measured from the principal axes, {number(problem.tilt)} rad away, the potential has its "
        f"three terms again; engines that know no tilt agree to {number(worst)} rad.",
        (
            "The source says that any symmetry may be absent and prints no term for it. The "
            "Lagrangian gains ½ I_yz ω² sin 2θ, which changes a, b and c to those of θ + tilt, "
            "with tan(2 tilt) = 2 I_yz/(I_y – I_z), and every formula of the source holds for that "
            "angle. I_xy and I_xz, like X, enter through ω θ̇ times a function of θ: a total "
            "derivative, without effect. Z does not enter at all.",
            "No body with the cone's other moments can have a product above 0.0294 kg m²: MuJoCo "
            "refuses such a body, and so does plumbob.",
        ),
        (
            Table(
                f"θ after {END} s from the start of Fig. 3",
                ("motion", f"θ({END} s) [rad]", "difference from the closed form [rad]"),
                tuple(rows),
            ),
        ),
        (),
        (
            f"plumbob solve {ROTATING} --set inertia_yz={PRODUCT} --times {END}",
            f"plumbob run {ROTATING} {MUJOCO} --step {MUJOCO_STEP:g} --set inertia_yz={PRODUCT} "
            "--set pivot_z=-0.7 --set pivot_x=0.5",
        ),
        (
            Statement(
                SUDAKOV,
                "characteristics",
                "Any symmetry may be absent",
                "no term for it",
                f"I_yz = {number(PRODUCT)} kg m² moves θ({END} s) by {number(moved)} rad; in "
                f"tilted axes the formulas hold, engines agree to {number(worst)} rad",
                "extended",
            ),
            Statement(
                SUDAKOV,
                "(6), (7)",
                "Terms that are total derivatives may be left out: X has no effect, nor has Z",
                "no X, no Z",
                "none: closed form"
                if carried is None
                else "none: in MuJoCo, with X = 0.5 m and "
                f"Z = –0.7 m, θ({END} s) changes by {number(carried)} rad",
                "holds",
            ),
        ),
        claims=(
            clear(
                "the motion by the product of inertia, and the engines' distance,",
                moved,
                worst,
                "rad",
            ),
        ),
    )


def _digits(angle: float) -> Cell:
    return Cell(f"{angle:.9f}", "number")
