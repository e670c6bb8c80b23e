"""The finding on a support that meets v_i = 0 and leaves at once."""

from __future__ import annotations

from itertools import pairwise
from types import MappingProxyType

import numpy as np

from plumbob.analytic.systems.three_points.motion import ThreePointMotion
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule_turn.modes import figures, slip_speeds
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number

SLENDER = MappingProxyType(
    {"inertia": 0.002, "radius": 0.12, "angular_acceleration": 130.0, "half_time": 0.08}
)  # the check body's masses nearer to C: a support is easier to move one way than the other
SIDES = (1e-6, 1e-5, 1e-4, 1e-3)  # [s] before and after


def motion() -> ThreePointMotion:
    """A turn of a body with little inertia, in which a support stops and leaves at once."""
    scene = find_scene("capsule-turn", SLENDER)
    found = system_of(scene).problem(scene.parameters).motion.single
    assert isinstance(found, ThreePointMotion)
    return found


def touches(found: ThreePointMotion) -> list[tuple[float, int]]:
    """Times [s] and supports (0, 1, 2) that stop and leave while the others slide."""
    return [
        (now.time, now.support)
        for before, now in pairwise(found.events)
        if before.mode == now.mode == "slide" and now.support >= 0
    ]


def finding() -> Finding:
    """The slip speed on either side of the stop, and what it means."""
    found, tau = motion(), SLENDER["half_time"]
    (time, support), *_ = touches(found)
    sides = np.array(SIDES)
    before, at, after = (
        slip_speeds(found, np.atleast_1d(when))[support]
        for when in (time - sides, time, time + sides)
    )
    rows = [
        row(value(s, 1), value(b), value(a), value(b / s), value(a / s))
        for s, b, a in zip(SIDES, map(float, before), map(float, after), strict=True)
    ]
    given = " ".join(f"--set {name}={amount:g}" for name, amount in SLENDER.items())
    return Finding(
        "capsule-turn-touch",
        "A support can stop and leave at once: a way on that the source's modes have not",
        "extended",
        f"At {number(time / tau, 4)} τ of a turn of a slender body A{support + 1} comes to "
        f"v = 0 ({number(float(at[0]), 1)} m/s), friction cannot hold it, and it leaves in another "
        "direction without a moment's rest.",
        (
            "The source lists sliding, one support at rest, and rest. Near v = 0 the direction of "
            "slip settles on a ray of its own, and speed falls to zero in finite time along it, "
            "though the force needed to hold the support is more than friction has. It goes on "
            "along another ray. That takes a support that is easier to move one way than across, "
            "and is no rare chance: every start nearby does the same. An integrator that takes a "
            "stop for a hold, or steps over it, goes wrong here.",
        ),
        (
            Table("Slip speed [m/s] before and after the stop",
                  ("time from it [s]", "before", "after", "before, over the time [m/s²]",
                   "after, over the time [m/s²]"), tuple(rows)),
        ),
        figures(found, tau),
        (f"plumbob solve capsule-turn {given} --json",),
    )  # fmt: skip
