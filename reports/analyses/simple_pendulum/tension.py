"""The force in the rod as the engines report it, and its error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from plumbob.analytic.systems.pendulums.rod_tension import tension
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.analyses.claims import clear
from plumbob.reports.analyses.measurements import case, runs
from plumbob.reports.analyses.simple_pendulum.notebook import SIMPLE
from plumbob.reports.view import notation
from plumbob.reports.view.content import Figure, Finding, Statement, Table, method_cell, row, value
from plumbob.reports.view.palette import GREY, PERIWINKLE, RED
from plumbob.reports.view.sources import NOTEBOOK
from plumbob.reports.view.traces import Trace, curve, linear, marks, over_time

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
DRAWN, DRAWN_STEP = (("mujoco/rk4", RED, 9), ("pymunk/tight", PERIWINKLE, 4)), 1e-2


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Each scene with each method at two steps, and the runs drawn."""
    drawn = runs(SCENES[:1], (method for method, _, _ in DRAWN), (DRAWN_STEP,), DURATION)
    return (*runs(SCENES, METHODS, STEPS, DURATION), *drawn)


def finding(study: Study) -> Finding:
    """Tension by MuJoCo's sensor and pymunk's impulse, against T of the exact motion and T of the
    engine's own state."""
    rows = []
    sensor = late = 0.0
    for scene in SCENES:
        for method, source in METHODS.items():
            recordings = [
                study.recording(request) for request in runs((scene,), (method,), STEPS, DURATION)
            ]
            errors = [_errors(scene, run) for run in recordings if run is not None]
            if len(errors) < len(STEPS):
                continue
            _, apart, left = errors[-1]
            of_mujoco = method.startswith("mujoco")
            sensor, late = (max(sensor, apart), late) if of_mujoco else (sensor, max(late, apart))
            numbers = (*(error for error, _, _ in errors), apart, None if of_mujoco else left)
            rows.append(
                row(scene.partition("/")[2], method_cell(method), source, *map(value, numbers))
            )
    both = any("mujoco" in line[1].text for line in rows) and late > 0.0
    coarse, fine = (f"{notation.short(step)} s" for step in STEPS)
    return Finding(
        "rod-tension",
        "Rod tension: MuJoCo's sensor is exact for its own state; pymunk's is late and has no sign",
        "measured",
        "Read a joint's force from MuJoCo's sensor: pymunk's joint impulse is late and has no "
        "sign. "
        f"MuJoCo's force sensor gives the tension T of its own θ and dθ/dt to "
        f"{notation.number(sensor)} N; pymunk's joint impulse over the step differs from that by "
        f"up to {notation.number(late)} N at {fine}.",
        (
            "T = mL(dθ/dt)² + mg cos θ. In MuJoCo the sensor is in a frame that turns with the "
            "rod, so its component along the rod is T with its sign, at the state when it is read: "
            "its error is that of the state and no more.",
            "pymunk reports the magnitude of the impulse that a joint applied over the last step. "
            "With a joint that closes in one step (pymunk/tight) the impulse over h is "
            "T(θ, dθ/dt) + mgh dθ/dt sin θ, to first order: nearly T at the start of the step. "
            "It does not say whether the rod pulls or pushes: the sign here is that of this sum at "
            "pymunk's own state. With default settings (pymunk/default) the impulse also closes "
            "the joint, which adds a term of first order too.",
        ),
        (
            Table(
                f"Largest error of the tension over {DURATION:g} s [N]",
                ("scene", "method", "reported by", f"error at {coarse}", f"error at {fine}",
                 f"difference from T of its own state at {fine}",
                 f"with mgh dθ/dt sin θ subtracted at {fine}"),
                tuple(rows),
                "Last column: the one before it after mgh dθ/dt sin θ is subtracted.",
            ),
        ),
        (_plot(study),),
        tuple(f"plumbob run {SCENES[0]} {method} --step 1e-3"
              for method in ("mujoco/rk4", "pymunk/tight")),
        (
            Statement(
                NOTEBOOK,
                "T",
                "Tension of the rod",
                "T = mLθ̇² + mg cos θ",
                f"MuJoCo's sensor, at its own state, within {notation.number(sensor)} N",
                "holds",
            ),),
        claims=(
            (clear("distances of pymunk's impulse and of MuJoCo's sensor from the state's tension",
                   late, sensor, "N"),)
            if both
            else ()
        ),
    )  # fmt: skip


def _errors(scene: str, run: Trajectory) -> tuple[float, float, float]:
    """Largest error of the tension [N], its distance from T of the engine's own state, and what of
    that is not the delay of an impulse; the first sample, before any step, left out."""
    problem, exact = case(scene).problem, case(scene).reference
    observed = {name: values[1:] for name, values in run.observables.items()}
    truth = exact.observe(run.times[1:])["tension"]
    theta, rate = observed["theta"], observed["theta_dot"]
    beside = observed["tension"] - tension(problem.length, problem.gravity, theta, rate)
    step = float(run.times[-1]) / run.steps
    delay = problem.gravity * step * rate * np.sin(theta)
    sizes = (np.abs(v).max() for v in (observed["tension"] - truth, beside, beside - delay))
    error, apart, left = (float(v) for v in sizes)
    return error, apart, left


def _plot(study: Study) -> Figure:
    scene = SCENES[0]
    times = np.linspace(0.0, DURATION, 240)
    exact = case(scene).reference.observe(times)["tension"]
    traces: list[Trace] = [curve(times, exact, colour=GREY, name="exact", width=3.0)]
    for method, colour, size in DRAWN:
        if (run := study.recording(ExtraRun(scene, method, DRAWN_STEP, DURATION))) is not None:
            dots = run.times[1::6], run.observables["tension"][1::6]
            traces.append(marks(*dots, colour, method, size))
    return over_time(
        "Tension of the rod in the large swing",
        f"Below zero the rod pushes. Marks: steps of {notation.short(DRAWN_STEP)} s.",
        traces,
        linear("T [N]"),
        wide=True,
        height=300,
    )
