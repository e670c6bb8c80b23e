"""The finding that eq. 22 holds along every line through C."""

from __future__ import annotations

import math

import numpy as np

from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import off, problem, run
from plumbob.reports.view.content import Cell, Finding, Table, row
from plumbob.reports.view.notation import number

LINES = ("ca1", "ca2", "ca3", "at-50", "at-123", "at-222")
METHODS = ("mujoco/euler+coulomb", "pymunk/feet")
STEP = 1e-3  # [s]


def finding() -> Finding:
    """The source's three lines and three others, with what two engines make of each."""
    scenes = [f"capsule-line/{case}" for case in LINES]
    rows = tuple(row(*_line(scene)) for scene in scenes)
    heads = (
        "scene", "angle to C–A₁ [°]", "Δx by eq. 22 [m]",
        *(text for method in METHODS for text in (
            f"{method}: relative error of Δx", "largest |heading| [rad]")),
    )  # fmt: skip
    turned = [float(cell.hint) for line in rows for cell in line if cell.hint]
    worst = f"no more than {number(max(turned), 2)} rad" if turned else "not at all"
    return Finding(
        "capsule-any-line",
        "Eq. 22 holds along every line through C, not only C–Aᵢ",
        "extended",
        "The normal forces of a body with its slider on a line through C have their centre on that "
        "line, so friction has no moment about C while the body slides along it. One straight leg "
        f"takes the body anywhere on a plane. In the engines it turns by {worst}.",
        (
            "Σ Nᵢ CAᵢ = m g r, with r the slider's place from C: the moment of friction against a "
            "motion along d is –f m g (r × d), which is zero when r is along d, whatever the "
            "triangle. The source argues by N₂ = N₃ on C–A₁, and so takes two legs.",
        ),
        (Table(f"Six lines at a step of {number(STEP)} s", heads, rows),),
        (),
        (f"plumbob validate --scenes {','.join(scenes)} --methods {','.join(METHODS)}",
         "plumbob solve capsule-line/at-123"),
    )  # fmt: skip


def _line(scene: str) -> list[str | Cell]:
    motion = problem(scene).motion
    cells: list[str | Cell] = [
        Cell(scene.partition("/")[2], "scene"),
        value(math.degrees(motion.direction) % 360.0),
        value(motion.displacement, 5),
    ]
    for method in METHODS:
        found = run(scene, method, STEP)
        turn = None if found is None else float(np.abs(found.observables["heading"]).max())
        shown = value(turn, 2)
        hint = "" if turn is None else f"{turn:.3g}"
        cells += [value(off(scene, method, STEP)), Cell(shown.text, shown.kind, hint)]
    return cells
