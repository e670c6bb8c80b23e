"""pymunk and this system: a torque of the angle, within a step and before it."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, as_predicted
from plumbob.reports.analyses.cone_pendulum.hamiltonian import ROTATING, forms
from plumbob.reports.analyses.energy_drift import energy

METHOD, STEP, DURATION = "pymunk/torque", 2e-4, 2.0  # [s]
RUNS = MappingProxyType(
    {
        when: ExtraRun(ROTATING, METHOD, STEP, DURATION, (), (("torque", when),))
        for when in ("within", "before")  # the step
    }
)


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """pymunk with the torque of the angle within the step, and before it."""
    return tuple(RUNS.values())


def explicit_gain(motion: PendulumMotion, step: float) -> float:
    """Mean rate [J/s] at which Euler's explicit rule raises the energy of a periodic `motion` at a
    `step` h [s]: a step adds h^2 (tau^2/I + V'' theta_dot^2)/2, and over a period the mean of
    V'' theta_dot^2 is that of tau^2/I, by parts; so h times the mean of tau^2/I."""
    times = np.linspace(0.0, motion.period, 1024, endpoint=False)
    bend = np.asarray(motion.rotor.acceleration(0.0, *motion.state(times)))
    return float(step * motion.inertia * np.mean(bend**2))


def numbers(study: Study) -> Record:
    """The energy that each recorded run gains, and the predicted growth."""
    motion = forms(ROTATING).correct
    growth = explicit_gain(motion, STEP)
    gains = {}
    for when, request in RUNS.items():
        if run := study.answer(request):
            values = energy(motion.potential, motion.inertia, run)
            gained = values - values[0]
            rate = float(np.polyfit(run.times, gained, 1)[0])
            predicted = growth if when == "before" else 0.0
            gains[when] = Record(
                times=run.times,  # [s]
                energies=gained,  # [J]
                largest=np.abs(gained).max(),  # magnitude [J]
                rate=rate,  # [J/s], of a line through them
                predicted=predicted,  # [J/s]
            )
    return Record(
        gains=gains,
        predicted=growth,  # [J/s], of the torque before the step
        end=growth * DURATION,  # energy [J] predicted to be gained in the whole run
        method=METHOD,
        step=STEP,
        duration=DURATION,
        scene=ROTATING,
    )


def claims(numbers: Record) -> Claims:
    """The energy grows as predicted where the torque is set before the step."""
    if "before" not in numbers.gains:
        return ()
    text = "the rate of the energy, with the torque set before the step,"
    return (as_predicted(text, numbers.gains["before"].rate, numbers.predicted, "J/s"),)


PYMUNK_TORQUE = Analysis("cone_pendulum/pymunk_torque", numbers, requests, claims)
