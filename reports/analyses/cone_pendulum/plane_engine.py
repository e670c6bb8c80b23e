"""The finding on pymunk and this system: a torque of the angle, within a step and before it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.claims import as_predicted
from plumbob.reports.analyses.cone_pendulum.hamiltonian import ROTATING, forms
from plumbob.reports.analyses.energy_drift import energy
from plumbob.reports.view.content import Figure, Finding, Table, row, value
from plumbob.reports.view.notation import number
from plumbob.reports.view.palette import BLUE, GREY, RED
from plumbob.reports.view.traces import Trace, curve, linear, over_time

METHOD, STEP, DURATION = "pymunk/torque", 2e-4, 2.0  # [s]
WHEN = ("within", "before")


def _request(when: str) -> ExtraRun:
    return ExtraRun(ROTATING, METHOD, STEP, DURATION, (), (("torque", when),))


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """pymunk with the torque of the angle within the step, and before it."""
    return tuple(_request(when) for when in WHEN)


def explicit_gain(motion: PendulumMotion, step: float) -> float:
    """Mean rate [J/s] at which Euler's explicit rule raises the energy of a periodic `motion` at a
    `step` h [s]: a step adds h^2 (tau^2/I + V'' theta_dot^2)/2, and over a period the mean of
    V'' theta_dot^2 is that of tau^2/I, by parts; so h times the mean of tau^2/I."""
    times = np.linspace(0.0, motion.period, 1024, endpoint=False)
    bend = np.asarray(motion.rotor.acceleration(0.0, *motion.state(times)))
    return float(step * motion.inertia * np.mean(bend**2))


def gained(study: Study, when: str) -> tuple[Array, Array] | None:
    """Times [s] and the energy gained [J] of a run, shape (n,); None where there is none."""
    run = study.recording(_request(when))
    if run is None:
        return None
    motion = forms(ROTATING).correct
    values = energy(motion.potential, motion.inertia, run)
    return run.times, values - values[0]


def finding(study: Study) -> Finding:
    """pymunk takes the torque; when it is worked out decides whether the energy is kept."""
    motion = forms(ROTATING).correct
    predicted = explicit_gain(motion, STEP)
    rows, slopes, energies = [], {}, {}
    for when in WHEN:
        if (gain := gained(study, when)) is None:
            continue
        energies[when] = gain
        slopes[when] = float(np.polyfit(*gain, 1)[0])
        rows.append(
            row(
                f"{when} the step",
                value(float(np.abs(gain[1]).max())),
                value(slopes[when], 4),
                value(predicted if when == "before" else 0.0, 4),
            )
        )
    text = ""
    if "before" in slopes:
        text = (
            f" Set before the step it is that of the old angle, and the energy grows by "
            f"{number(slopes['before'])} J/s; {number(predicted)} is predicted."
        )
    return Finding(
        "pymunk-torque",
        "pymunk follows the pendulum under a torque of its angle, if that is set within the step",
        "extended",
        "In pymunk set a torque that depends on an angle within the step; set before it, the "
        "energy grows. "
        "An engine of the plane has no rotating platform; the platform's moments about the axle "
        f"are applied as a torque, and its errors are the predicted ones.{text}",
        (
            "pymunk moves bodies first and integrates their velocities then. A torque set before "
            "the step is that of the old angle, which makes the step Euler's explicit rule: the "
            "energy grows by h times the mean of τ²/I, a first-order drift in every system. A "
            "velocity function is called between the two, and the step is semi-implicit: the "
            "energy oscillates and does not grow.",
        ),
        (
            Table(
                f"Energy of pymunk's runs, {DURATION:g} s at {STEP:g} s, from the start of Fig. 3",
                ("torque worked out", "largest error of the energy [J]", "growth [J/s]",
                 "predicted growth [J/s]"),
                tuple(rows),
            ),
        ),
        _figures(energies, predicted),
        (f"plumbob validate --scenes {ROTATING} --methods {METHOD}",),
        claims=(
            (as_predicted("the rate of the energy, with the torque set before the step,",
                          slopes["before"], predicted, "J/s"),)
            if "before" in slopes
            else ()
        ),
    )  # fmt: skip


def _figures(energies: dict[str, tuple[Array, Array]], predicted: float) -> tuple[Figure, ...]:
    if not energies:
        return ()
    traces: list[Trace] = [
        curve(*energies[when], colour=colour, name=f"torque {when} the step")
        for when, colour in zip(WHEN, (BLUE, RED), strict=True)
        if when in energies
    ]
    ends = np.array([0.0, DURATION])
    line = curve(ends, predicted * ends, colour=GREY, dash="dash", name="predicted growth")
    caption = "Semi-implicit and explicit, by the place of one call."
    title, axis = "Energy of pymunk's pendulum", linear("energy gained [J]")
    return (over_time(title, caption, [*traces, line], axis),)
