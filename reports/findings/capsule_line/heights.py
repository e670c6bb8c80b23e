"""The finding on heights, which the source takes as zero: what a body of real height does."""

from __future__ import annotations

import numpy as np

from plumbob.engines.registry import method as find_method
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule.runs import COLOURS, GREY, off, problem, run
from plumbob.reports.view.content import Cell, Finding, Table, row
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.traces import Trace, curve, figure, linear

SCENE = "capsule-line/at-123"
STEP, FINE = 1e-3, 1e-4  # [s]
LOW, TALL = "mujoco/euler+coulomb", "mujoco/euler+tall"
LOAD = "normal_force_2"


def finding() -> Finding | None:
    """Loads and displacement of a capsule whose C and Q are over the plane."""
    found = {name: one for name in (LOW, TALL) if (one := run(SCENE, name, STEP)) is not None}
    if len(found) < 2:
        return None
    posed = problem(SCENE)
    height = float(find_method(TALL).settings["height"])
    moment = posed.setup.capsule.friction * posed.setup.capsule.weight * height
    times = np.linspace(0.0, float(found[LOW].times[-1]), 200)
    statics = posed.reference.observe(times)[LOAD]
    traces: list[Trace] = [curve(times, statics, colour=GREY, width=2.2, name="statics, no height")]
    for name in (LOW, TALL):
        traces.append(curve(found[name].times, found[name].observables[LOAD], colour=COLOURS[name],
                            name=name))  # fmt: skip
    loads = {name: one.observables[LOAD] for name, one in found.items()}
    shift = float(np.abs(loads[TALL] - loads[LOW]).max())
    rows, change = [], {}
    for step in (STEP, FINE):
        ends = {name: off(SCENE, name, step) or 0.0 for name in found}
        change[step] = abs(ends[TALL] - ends[LOW])
        for name, end in ends.items():
            if (one := run(SCENE, name, step)) is None:
                continue
            load, turn = one.observables[LOAD], np.abs(one.observables["heading"])
            cells = (end, float(turn.max()), float(load.min()), float(load.max()))
            rows.append(row(named(name), Cell(short(step), "number"), *map(value, cells)))
    heads = ("method", "step [s]", "relative error of Δx", "largest |heading| [rad]",
             "least N₂ [N]", "largest N₂ [N]")  # fmt: skip
    return Finding(
        "capsule-heights",
        "Heights shift the loads and leave the motion",
        "measured",
        f"With C and the slider {number(100 * height)} cm over the plane N₂ shifts by up to "
        f"{number(shift, 2)} N, and Δx by {number(change[STEP], 2)} of itself at a step of "
        f"{short(STEP)} s, {number(change[FINE], 2)} at {short(FINE)} s.",
        (
            f"Friction acts h below the combined centre. While the body slides its moment is "
            f"f (M+m) g h = {number(moment)} N m; while the body is held, m w₂ h the other way. "
            "That moves loads along the line and not across it, so friction still balances about "
            "C, and its sum is f times the weight whatever the shares are. What is left of a "
            "change in Δx is the contacts' swinging as the moment comes and goes, and goes with "
            "the step. The limit is a support that lifts off.",
        ),
        (Table(SCENE.partition("/")[2], heads, tuple(rows)),),
        (figure("Normal force at A₂", f"At a step of {number(STEP)} s.", traces,
                linear("time [s]"), linear("N₂ [N]"), legend=True, wide=True),),
        (f"plumbob run {SCENE} {TALL} --step 1e-3",),
    )  # fmt: skip
