"""The source's Fig. 2: velocities of slider and body over time, exact and from two engines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.reports.findings.capsule.runs import COLOURS, GREY, LINE, problem, run
from plumbob.reports.view.content import Figure
from plumbob.reports.view.notation import number
from plumbob.reports.view.traces import Trace, curve, figure, linear

STEP = 1e-3  # [s]
ENGINES = (("mujoco/euler+coulomb", "MuJoCo"), ("pymunk/side", "pymunk"))
EVERY = 5  # samples to a mark
TIME = "time [s]"


def galleries() -> Sequence[tuple[str, Sequence[Figure]]]:
    """v(t), v_c(t) and x(t) of the check manoeuvre."""
    line = problem(LINE).motion
    switches = (
        f"t₁ = {number(line.t1)} s, t* = {number(line.t_star, 5)} s, t₂ = {number(line.t2, 5)} s."
    )
    panels = (
        ("v(t): the slider in the body", "stroke_rate", "v [m/s]", switches),
        ("v_c(t): the body", "velocity", "v_c [m/s]", "Backwards until t*, then at rest."),
        ("x(t): the body", "displacement", "x [m]",
         f"Δx = {number(line.displacement, 5)} m, eq. 22."),
    )  # fmt: skip
    figures = tuple(_panel(*panel) for panel in panels)
    return ((f"Chernousko's Fig. 2: exact, and measured at a step of {number(STEP)} s", figures),)


def _panel(title: str, name: str, axis: str, caption: str) -> Figure:
    reference = problem(LINE).reference
    motion = problem(LINE).motion
    end = 1.05 * motion.t2
    # The switches among the times, so that a corner is drawn as one.
    times = np.unique(np.append(np.linspace(0.0, end, 200), [motion.t1, motion.t_star, motion.t2]))
    traces: list[Trace] = [
        curve(times, reference.observe(times)[name], colour=GREY, width=2.2, name="exact")
    ]
    for place, (method, shown) in enumerate(ENGINES):
        if (found := run(LINE, method, STEP)) is not None:
            kept = slice(place * EVERY // 2, None, EVERY)
            dots = found.times[kept], found.observables[name][kept]
            traces.append(curve(*dots, colour=COLOURS[method], marks=True, lines=False, name=shown))
    return figure(title, caption, traces, linear(TIME), linear(axis), legend=True, height=300)
