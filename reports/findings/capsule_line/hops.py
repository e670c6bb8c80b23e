"""The finding that MuJoCo's default contacts do not converge, because the body hops on them."""

from __future__ import annotations

import numpy as np

from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule.runs import COLOURS, LINE, off, problem, run
from plumbob.reports.view.content import Cell, Finding, Table, row
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic

DEFAULT, GOOD = "mujoco/euler", "mujoco/euler+coulomb"
STEPS = (1e-3, 1e-4)  # [s]; the figures are at the finer one
FLOOR = 1e-14  # [m] where a heave of zero is drawn
LOADS = tuple(f"normal_force_{i}" for i in (1, 2, 3))


def finding() -> Finding | None:
    """Heave, contacts and normal force over time, default against convergent."""
    motion = problem(LINE).motion
    weight, rows = motion.capsule.weight, []
    heaves: list[Trace] = []
    contacts: list[Trace] = []
    forces: list[Trace] = []
    for name in (DEFAULT, GOOD):
        for step in STEPS:
            if (found := run(LINE, name, step)) is None:
                return None
            heave, count = found.channels["heave"], found.channels["contacts"]
            load = np.sum([found.observables[n] for n in LOADS], axis=0) / weight
            sliding = found.times < motion.t_star
            missing = float(np.mean(count[sliding] < 3))
            cells = (off(LINE, name, step), float(np.ptp(heave)), missing,
                     float(count.min()), float(load.min()), float(load.max()))  # fmt: skip
            rows.append(row(named(name), Cell(short(step), "number"), *map(value, cells)))
            if step == STEPS[-1]:
                sizes = np.maximum(np.abs(heave), FLOOR)
                heaves.append(curve(found.times, sizes, colour=COLOURS[name], name=name))
                contacts.append(curve(found.times, count, colour=COLOURS[name], name=name))
                forces.append(curve(found.times, load, colour=COLOURS[name], name=name))
    heads = ("method", "step [s]", "relative error of Δx", "heave, top to bottom [m]",
             "samples with a contact missing while it slides", "fewest contacts",
             "least ΣNᵢ over the weight", "largest")  # fmt: skip
    hop, missing = (float(rows[1][i].text) for i in (3, 4))
    at, time = f"At a step of {short(STEPS[-1])} s.", linear("time [s]")
    return Finding(
        "capsule-hops",
        "On MuJoCo's default contacts a sliding body hops, and no step mends it",
        "known limit",
        f"While the body slides, a contact is missing in {number(100 * missing, 2)} % of the "
        f"samples at {short(STEPS[-1])} s, the body heaves by {number(1e6 * hop, 2)} µm, and the "
        "force on the plane swings between nothing and nearly twice the weight. A smaller step "
        "has all of that, too.",
        (
            "The convex friction cone couples slip speed to normal force: sliding contacts push "
            "the body off the plane, it falls back and rubs harder than its weight allows. The "
            "friction is right on the average, but a manoeuvre is too short for an average. Soft "
            "along the normal and hard across it, contacts keep the weight on the plane: that is "
            "the profile coulomb.",
            "Every method with such contacts is declared not-converging, strictly: should a "
            "release of MuJoCo mend it, the run says so and fails.",
        ),
        (Table("Default contacts beside those that converge, ca1", heads, tuple(rows)),),
        (
            figure("Heave of the body", f"{at} From where it rests.", heaves, time,
                   logarithmic("|heave| [m]"), legend=True),
            figure("Supports in contact", f"{at} Of three.", contacts, time,
                   linear("contacts [1]", dtick=1), legend=True),
            figure("Force on the plane", f"{at} It is to be 1.", forces, time,
                   linear("ΣNᵢ / (M+m)g"), legend=True, wide=True, height=280),
        ),
        (f"plumbob validate --scenes {LINE} --methods {DEFAULT},{GOOD}",),
    )  # fmt: skip
