"""What the engines can tell of the force in the rod, and what it is off by."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from plumbob.analytic.systems.pendulums.rod_tension import tension
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.findings.fresh_runs import run
from plumbob.reports.findings.simple_pendulum.problems import SIMPLE, case, number
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Figure, Finding, Table, row
from plumbob.reports.view.traces import Trace, curve, figure, linear

SCENES = (f"{SIMPLE}free-large", f"{SIMPLE}rotating-fast", f"{SIMPLE}forced-large")
METHODS: Mapping[str, str] = MappingProxyType(
    {
        "mujoco/euler": "force sensor at the axis",
        "mujoco/rk4": "force sensor at the axis",
        "pymunk/tight": "|impulse| of the joint / h",
        "pymunk/default": "|impulse| of the joint / h",
    }
)
STEPS, DURATION = (2e-3, 1e-3), 3.0  # [s]


def finding() -> Finding:
    """Tension by MuJoCo's sensor and pymunk's impulse, against T of the exact motion and T of the
    engine's own state."""
    rows = []
    sensor = late = 0.0
    for scene in SCENES:
        for method, source in METHODS.items():
            runs = [run(scene, method, step, DURATION) for step in STEPS]
            if any(found is None for found in runs):
                continue
            off = [_off(scene, found) for found in runs if found is not None]
            if method.startswith("mujoco"):
                sensor = max(sensor, off[-1][1])
            else:
                late = max(late, off[-1][1])
            left = off[-1][2] if method.startswith("pymunk") else None
            values = (*(errors for errors, _, _ in off), off[-1][1], left)
            rows.append(
                row(scene.partition("/")[2], Cell(method, "method"), source, *map(number, values))
            )
    coarse, fine = (f"{notation.short(step)} s" for step in STEPS)
    return Finding(
        "rod-tension",
        "Rod tension: MuJoCo tells it exactly of its own state; pymunk late, and without its sign",
        "measured",
        f"MuJoCo's force sensor is T of its own θ and dθ/dt to {notation.number(sensor)} N; "
        f"pymunk's joint impulse over the step differs from that by up to "
        f"{notation.number(late)} N at {fine}.",
        (
            "T = mL(dθ/dt)² + mg cos θ. In MuJoCo the sensor stands in a frame that turns with the "
            "rod, so its component along the rod is T, signs and all, at the state that it is read "
            "at: its error is that of the state and no more.",
            "pymunk tells the magnitude of the impulse that a joint applied over the last step. "
            "With the joint closed in a step (pymunk/tight) the impulse over h is "
            "T(θ, dθ/dt) + mgh dθ/dt sin θ, to first order: T where the step began, nearly. "
            "Whether the rod pulls or pushes it does not say: the sign here is that of this sum at "
            "pymunk's own state. As it comes (pymunk/default) the impulse also closes the joint; "
            "that share is of first order too.",
        ),
        (
            Table(
                f"Largest error of the tension over {DURATION:g} s [N]",
                ("scene", "method", "told by", f"error at {coarse}", f"error at {fine}",
                 f"from T of its own state at {fine}",
                 f"beside mgh dθ/dt sin θ at {fine}"),
                tuple(rows),
                "Last column: what is left of the one before it when mgh dθ/dt sin θ is taken off.",
            ),
        ),
        (_plot(),),
        tuple(f"plumbob run {SCENES[0]} {method} --step 1e-3"
              for method in ("mujoco/rk4", "pymunk/tight")),
    )  # fmt: skip


def _off(scene: str, found: Trajectory) -> tuple[float, float, float]:
    """Largest error of the tension [N], its distance from T of the engine's own state, and what of
    that is not the lag of an impulse; the first sample, before any step, left out."""
    problem, exact = case(scene).problem, case(scene).exact
    seen = {name: values[1:] for name, values in found.observables.items()}
    truth = exact.observe(found.times[1:])["tension"]
    theta, rate = seen["theta"], seen["theta_dot"]
    beside = seen["tension"] - tension(problem.length, problem.gravity, theta, rate)
    step = float(found.times[-1]) / found.steps
    lag = problem.gravity * step * rate * np.sin(theta)
    sizes = (np.abs(v).max() for v in (seen["tension"] - truth, beside, beside - lag))
    error, own, left = (float(v) for v in sizes)
    return error, own, left


def _plot() -> Figure:
    scene, until, step = SCENES[0], 3.0, 1e-2
    times = np.linspace(0.0, until, 240)
    exact = case(scene).exact.observe(times)["tension"]
    traces: list[Trace] = [curve(times, exact, colour="#808080", name="exact", width=3.0)]
    for method, colour, size in (("mujoco/rk4", "#d55e00", 9), ("pymunk/tight", "#5a78d2", 4)):
        if (found := run(scene, method, step, until)) is not None:
            dots = found.times[1::6], found.observables["tension"][1::6]
            trace = curve(*dots, colour=colour, marks=True, lines=False, name=method)
            traces.append({**trace, "marker": {**trace["marker"], "size": size}})
    return figure(
        "Tension of the rod in the large swing",
        f"Below zero the rod is pushed. Dots: steps of {notation.short(step)} s.",
        traces,
        linear("time [s]"),
        linear("T [N]"),
        legend=True,
        wide=True,
        height=300,
    )
