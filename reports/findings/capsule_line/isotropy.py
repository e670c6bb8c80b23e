"""The finding on headings: the same manoeuvre with everything turned."""

from __future__ import annotations

import numpy as np

from plumbob.engines.study.results import Study
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule.runs import COLOURS, off
from plumbob.reports.view.content import Cell, Finding, Table, row
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic, positive

METHODS = (
    "mujoco/euler",
    "mujoco/euler+elliptic",
    "mujoco/euler+coulomb",
    "pymunk/feet",
)
QUICK = (0, 30, 105, 225)  # [degrees]
FULL = tuple(range(0, 360, 15))


def finding(study: Study) -> Finding | None:
    """Relative error of the displacement at each heading, and its spread."""
    full = study.profile == "full"
    headings, steps = (FULL, (1e-3, 1e-4)) if full else (QUICK, (1e-3,))
    rows: list[tuple[Cell, ...]] = []
    traces: list[Trace] = []
    spreads = {}
    for name in METHODS:
        for step in steps:
            errors = [off(f"capsule-line/heading-{angle:03d}", name, step) for angle in headings]
            known = np.array([error for error in errors if error is not None])
            if len(known) < len(headings):
                continue
            least, most = float(known.min()), float(known.max())
            spreads[name] = most - least
            cells = (len(known), least, most, most - least)
            rows.append(row(named(name), Cell(short(step), "number"), *map(value, cells)))
            if step == steps[0]:
                traces.append(curve(np.array(headings), positive(known), colour=COLOURS[name],
                                    marks=True, name=name))  # fmt: skip
    if not rows:
        return None
    shipped, good = spreads.get("mujoco/euler"), spreads.get("mujoco/euler+coulomb")
    told = (
        f" The displacement varies by {number(shipped, 2)} of itself over the headings with "
        f"MuJoCo's default contacts and by {number(good, 2)} with those that converge."
        if shipped is not None and good is not None
        else ""
    )
    heads = ("method", "step [s]", "headings", "least error", "largest error", "spread")
    return Finding(
        "capsule-isotropy",
        "Pyramidal friction depends on the heading; heading 0 hides it",
        "measured",
        f"Everything is turned by a heading, and the exact answer stays.{told}",
        (
            "A pyramid of four edges reaches f only at its edges, which lie along the contact's "
            "own axes: between them it has 0.71 of it. An elliptic cone is round but hops all the "
            "same. A joint of pymunk's has a disc for its largest force.",
        ),
        (Table("Relative error of Δx over headings", heads, tuple(rows)),),
        (figure("Error of Δx against heading", f"At a step of {short(steps[0])} s.", traces,
                linear("heading [°]", dtick=45), logarithmic("|error of Δx| / |Δx|"), legend=True,
                wide=True),),
        ("plumbob validate --profile full --scenes 'capsule-line/heading-*' --methods "
         f"{','.join(METHODS)}",),
    )  # fmt: skip
