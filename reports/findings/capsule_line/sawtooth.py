"""The finding that the error of the final displacement is half phi (1 - phi)(mu w2 + f g) dt^2."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.errors.discontinuities import trapezoid_error
from plumbob.engines.adapters.mujoco.contact_profiles import PROFILES
from plumbob.engines.study.study import Study
from plumbob.reports.findings.capsule.cells import named, value
from plumbob.reports.findings.capsule.runs import (
    COLOURS,
    GREY,
    LINE,
    displaced,
    problem,
)
from plumbob.reports.findings.capsule.surplus import sinking
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.traces import Trace, curve, figure, linear

METHODS = (
    "mujoco/euler+reduced",
    "mujoco/euler+coulomb",
    "pymunk/side",
    "pymunk/feet",
)
FULL = "mujoco/euler+coulomb"
COUNT = 4  # steps drawn at random, fifteen times as many in the full profile
COARSE, FINE = 2.5e-3, 6e-4  # [s], what they are drawn between
SEED = 20200101
RULES = 0.2  # of the parabola's top: below it, other terms rule


def finding(study: Study) -> Finding | None:
    """The errors at steps drawn at random against the parabola, and how near they are."""
    many = COUNT * (15 if study.profile == "full" else 1)
    line = problem(LINE).motion
    unit = line.closed.braking
    draw = np.random.default_rng(SEED).uniform(np.log(FINE), np.log(COARSE), many)
    steps = [float(step) for step in np.exp(draw)]
    phi = np.linspace(0.0, 1.0, 101)
    traces: list[Trace] = [
        curve(phi, 0.5 * phi * (1 - phi), colour=GREY, width=2.0, name="½φ(1–φ)")
    ]
    # The sinking is the same part of dt^2 at every step.
    sunk = -sinking(LINE, line.t1 / 100, PROFILES["coulomb"]) / (unit * (line.t1 / 100) ** 2)
    traces.append(
        curve(phi, 0.5 * phi * (1 - phi) + sunk, colour=GREY, dash="dash", name="and sinking")
    )
    rows = []
    for name in METHODS:
        found = _errors(name, steps)
        if not found:
            continue
        places, errors, apart = (np.array(column) for column in zip(*found, strict=True))
        traces.append(
            curve(places, errors, colour=COLOURS[name], marks=True, lines=False, name=name)
        )
        said = 0.5 * places * (1 - places)
        rules = said > RULES / 8
        rows.append(
            row(named(name), value(float(len(found))),
                value(float(np.abs(errors / said - 1)[rules].max())),
                value(float(np.abs((errors - apart) / said - 1)[rules].max())))
        )  # fmt: skip
    if not rows:
        return None
    heads = ("method", "steps", "largest distance from ½φ(1–φ)", "with the sinking added")
    return Finding(
        "capsule-sawtooth",
        "The error is ½φ(1–φ)(μw₂+fg)dt², in both engines, at any step",
        "confirmed",
        "φ is the fraction of t*/dt. The error is a sawtooth in the step, so a slope fitted to it "
        "says nothing, a step_sizes of round steps may flatter it, and its coefficient is the test.",
        (
            f"Steps drawn at random from {short(FINE)} to {short(COARSE)} s (seed {SEED}). Off the "
            "grid the switch at t₁ bends the velocity inside a step too, by μ(w₁+w₂): the same "
            "parabola in the fraction of t₁/dt, with the other sign, which is taken off here.",
            f"The full MuJoCo model's points lie {number(8 * sunk, 2)} of the parabola's top "
            "higher, by the sinking of its contacts, which goes with dt² too.",
        ),
        (Table("Distance from the parabola, relative, where that is above a fifth of its top",
               heads, tuple(rows)),),
        (figure("Error of Δx over (μw₂+fg)dt²", "Against φ, at steps drawn at random.", traces,
                linear("φ = frac(t* / dt)"), linear("–error / ((μw₂+fg) dt²)"), legend=True,
                wide=True),),
        tuple(f"plumbob run {LINE} {name} --step 0.00061" for name in (FULL, "pymunk/feet")),
    )  # fmt: skip


def _errors(method: str, steps: Sequence[float]) -> list[tuple[float, float, float]]:
    """phi, the error over -(mu w2 + f g) dt^2 without the bend at t1, and its part by sinking."""
    line, found = problem(LINE).motion, []
    jump = line.closed.backward + line.closed.braking
    for step in steps:
        if (end := displaced(LINE, method, step)) is None:
            continue
        unit = -line.closed.braking * step**2
        bent = float(trapezoid_error(jump, np.array(line.t1 / step))) * step**2
        sunk = sinking(LINE, step, PROFILES["coulomb"]) if method == FULL else 0.0
        phi = line.t_star / step % 1.0
        found.append((phi, (end - line.displacement - bent) / unit, sunk / unit))
    return found
