"""The finding that the printed I_x stands for I_y: a body without symmetry tells them apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from plumbob.reports.findings.cone_pendulum.problems import MUJOCO, MUJOCO_STEP, case
from plumbob.reports.findings.fresh_runs import run
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Finding, Table, row

SCENE = "cone-pendulum/unequal-inertia"
END = 0.5  # [s]


def finding() -> Finding:
    """MuJoCo against the formula with I_y and with the printed I_x."""
    problem = case(SCENE).problem
    body = problem.body
    printed = replace(problem, body=replace(body, inertia_y=body.inertia_x))
    at = np.array([END])
    with_y, with_x = (float(p.motion.state(at)[0][0]) for p in (problem, printed))
    engine = run(SCENE, MUJOCO, MUJOCO_STEP, END)
    spread = body.inertia_y - body.inertia_x
    rows = [
        row("closed form with I_y", _digits(with_y), ""),
        row("closed form with the printed I_x", _digits(with_x), _number(with_x - with_y)),
    ]
    said = "the formula with I_y"
    if engine is not None:
        final = float(engine.observables["theta"][-1])
        rows.append(row("MuJoCo's full model", _digits(final), _number(final - with_y)))
        said = f"MuJoCo sides with I_y to {notation.number(abs(final - with_y))} rad"
    table = Table(
        f"A body with I_y = I_x + {notation.number(spread)} kg m²",
        ("who", f"θ({END} s) [rad]", "from the formula with I_y [rad]"),
        tuple(rows),
    )
    return Finding(
        "inertia-y",
        "Where the source prints I_x, its Lagrangian needs I_y",
        "misprint",
        f"The source says that any symmetry may be absent; then the printed I_x is off by "
        f"{notation.number(abs(with_x - with_y))} rad after {END} s, and {said}.",
        (
            "The platform's rotation reaches the body through its moments about y and z, since the "
            "swing is about x: a = ½(I_y – I_z)ω². For a cone I_x = I_y and nothing shows; the "
            "source adds that the body may lack any symmetry, and then the letter matters.",
        ),
        (table,),
        (),
        (f"plumbob run {SCENE} {MUJOCO} --step 1e-4", f"plumbob solve {SCENE} --times {END}"),
    )


def _digits(value: float) -> Cell:
    return Cell(f"{value:.9f}", "number")


def _number(value: float) -> Cell:
    return Cell(notation.number(value), "number")
