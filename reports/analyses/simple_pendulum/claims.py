"""The notebook's statements on its cases, one by one, beside the exact motions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.measurements import case, convergence_of, largest
from plumbob.reports.analyses.simple_pendulum.notebook import (
    DURATION,
    LINEAR,
    SIMPLE,
    at_every_step,
    difference,
    own_run,
)
from plumbob.reports.view.content import (
    Figure,
    Finding,
    Statement,
    StatementVerdict,
    Table,
    row,
    value,
)
from plumbob.reports.view.notation import number, short
from plumbob.reports.view.palette import BLUE, GREY
from plumbob.reports.view.sources import NOTEBOOK, judged
from plumbob.reports.view.traces import Trace, curve, linear, marks, over_time

TIMES = np.linspace(0.0, DURATION, 5001)  # [s], 200 in a period
SEEN = 0.05  # of the amplitude: a difference that a plot shows
DEGREE = math.pi / 180
SETTLED = 40.0  # [s]: a forced swing, damped at 0.2/s, has forgotten its start to 2 %
MUJOCO = "mujoco/rk4"


@dataclass(frozen=True)
class Parting:
    """How the linear motion of a case leaves the non-linear one."""

    largest: float  # difference within DURATION [rad]
    relative: float  # the same over the amplitude at the start
    seen: float  # time of a difference of SEEN of the amplitude [s], or infinite
    in_runs: float | None  # the largest difference in the notebook's own RK4 [rad]


def angle(scene: str) -> Array:
    """theta [rad] of the exact motion at TIMES."""
    return case(scene).reference.observe(TIMES)["theta"]


def parting(study: Study, name: str) -> Parting:
    """The difference of the exact motions of a case, and of the notebook's own runs of it."""
    amplitude = abs(float(angle(SIMPLE + name)[0]))
    over = np.flatnonzero(np.abs(difference(TIMES, name)) > SEEN * amplitude)
    nonlinear, linear = (study.recording(own_run(kind + name)) for kind in (SIMPLE, LINEAR))
    in_runs = None
    if nonlinear is not None and linear is not None:
        apart = (nonlinear.observables[n] - linear.observables[n] for n in ("theta", "theta_dot"))
        in_runs = float(np.abs(at_every_step(nonlinear.times, *apart)).max())
    most = largest(partial(difference, name=name), TIMES)
    parted_at = float(TIMES[over[0]]) if over.size else math.inf
    return Parting(most, most / amplitude, parted_at, in_runs)


def swing(scene: str, times: Array = TIMES) -> float:
    """Largest angle [rad] of an exact motion from the first to the last of `times` [s]."""
    return largest(lambda t: case(scene).reference.observe(t)["theta"], times)


def turns(name: str) -> float:
    """Turns of a rotation within DURATION, from where it starts."""
    start, end = angle(SIMPLE + name)[[0, -1]]
    return abs(float(end - start)) / math.tau


def decay(name: str) -> float:
    """Largest relative difference of the extreme angles of a damped swing from |theta_0| times
    exp(-xi t/2)."""
    observed, rate = case(SIMPLE + name).reference.observe(TIMES), case(SIMPLE + name).problem
    speed, theta = observed["theta_dot"], observed["theta"]
    turns = np.flatnonzero(speed[:-1] * speed[1:] < 0.0)
    part = speed[turns] / (speed[turns] - speed[turns + 1])
    after = part * (TIMES[1] - TIMES[0])
    when = TIMES[turns] + after
    sizes = np.abs(theta[turns] + 0.5 * after * speed[turns])  # theta_dot falls linearly to zero
    expected = abs(rate.theta) * np.exp(-0.5 * rate.damping_rate * when)
    return float(np.abs(sizes / expected - 1.0).max())


def forced(name: str) -> tuple[float, float]:
    """Largest angles [rad] of the pendulum and of the linear one after SETTLED."""
    nonlinear, linear = (swing(kind + name, TIMES[TIMES >= SETTLED]) for kind in (SIMPLE, LINEAR))
    return nonlinear, linear


def lengthening(name: str) -> float:
    """Period of a free swing over that of the linear pendulum, less 1."""
    problem = case(SIMPLE + name).problem
    natural = math.tau * math.sqrt(problem.length / problem.gravity)
    return float(problem.elliptic.period) / natural - 1.0


def over_the_top(name: str) -> float:
    """Speed of a rotation at its start over the one that just reaches the top, less 1."""
    problem = case(SIMPLE + name).problem
    least = math.sqrt(2.0 * problem.gravity / problem.length * (1.0 + math.cos(problem.theta)))
    return float(abs(problem.theta_dot)) / least - 1.0


def _in_mujoco(study: Study) -> str:
    """The error [rad] of MuJoCo's multibody model on case 2 against the equation's solution."""
    series = convergence_of(study, SIMPLE + "free-large", MUJOCO)
    done = [m for m in series.measurements if m.status == "done"] if series else []
    if not done:
        return "solved exactly"
    error = done[-1].errors["theta"].largest
    return (
        f"solved exactly; MuJoCo's multibody model follows it on case 2 within "
        f"{number(error)} rad at {short(done[-1].step)} s"
    )


def finding(study: Study) -> Finding:
    """The notebook's statements with a verdict each."""
    small, large, damped = (
        parting(study, name) for name in ("free-small", "free-large", "damped-small")
    )
    natural = math.sqrt(9.8)
    fast_swing, slow_swing = (
        swing(f"{LINEAR}rotating-{speed}") / DEGREE for speed in ("fast", "slow")
    )
    caught = angle(SIMPLE + "damped-rotating")
    exponential, strong = decay("damped-small"), decay("damped-large")
    dying = parting(study, "damped-large")
    pushed, wide = forced("forced-large"), "forced-large"
    longer = [lengthening(name) for name in ("free-small", "free-large")]
    texts: tuple[tuple[str, str, str, str, StatementVerdict, str], ...] = (
        ("equation of motion", "mLθ̈ + CLθ̇ + mg sin θ = F(t)", "Newton's law",
            _in_mujoco(study), "holds", ""),
        ("linear equation", "for θ ≪ 1, sin θ ≈ θ", "θ ≪ 1",
            f"the period is longer by {number(100 * longer[0], 3)} % at 10° and by "
            f"{number(100 * longer[1], 3)} % at 120°", "holds", ""),
        ("F(t)", "A sin Ωt excites the pendulum", "in the code, A = 0 in every case",
            f"scenes of our own: after {SETTLED:g} s of {wide} the swing is "
            f"{number(pushed[0])} rad, that of the linear pendulum {number(pushed[1])} rad",
            "extended", ""),
        ("case 1", "linear and non-linear are similar", "similar",
            f"{number(small.largest)} rad apart within {DURATION:g} s, "
            f"{number(100 * small.relative, 2)} % of the amplitude; {100 * SEEN:g} % after "
            f"{number(small.seen, 2)} s", "corrected", "at first"),
        ("case 2", "at 120° they are not", "different",
            f"{number(large.largest)} rad apart; {100 * SEEN:g} % after {number(large.seen, 2)} s",
            "holds", ""),
        ("case 3", "the two are compared at 200°/s", "a plot",
            f"the pendulum rotates, {number(100 * over_the_top('rotating-slow'), 3)} % faster than "
            f"the top takes: {number(turns('rotating-slow'), 4)} turns in "
            f"{DURATION:g} s; the linear one swings by {number(slow_swing, 4)}°", "extended", ""),
        ("case 4", "θ₀ = 500°/s", "500°/s", "dθ/dt at the start; θ₀ is –120°", "corrected",
            "a misprint"),
        ("case 4", "the linear pendulum has no physical sense", "peculiar",
            f"it swings by {number(fast_swing, 4)}° while the pendulum rotates: "
            f"{number(turns('rotating-fast'), 4)} turns in {DURATION:g} s",
            "holds", ""),
        ("case 5", "linear and non-linear are similar", "similar",
            f"{number(damped.largest)} rad apart at most, {number(100 * damped.relative, 2)} % of "
            "the amplitude", "holds", ""),
        ("case 5", "the decay is exponential", "exponential",
            f"extremes within {number(100 * exponential, 2)} % of |θ₀| exp(–ξt/2); in case 6 "
            f"{number(100 * strong, 2)} %", "holds", "for small swings"),
        ("case 6", "at 120° damped, they are not", "different",
            f"{number(dying.largest)} rad apart; {100 * SEEN:g} % after {number(dying.seen, 2)} s",
            "holds", ""),
        ("case 7", "the pendulum is non-linear", "different",
            f"it goes over the top, is caught and comes to rest "
            f"{number(float(caught[-1]) / math.tau, 2)} turns on", "extended", ""),
        ("parameters", "ξ is the damping ratio", "0.08",
            "a rate, C/m = 0.08/s; the damping ratio is "
            f"ξ/(2√(g/L)) = {number(0.08 / (2 * natural), 3)}", "corrected", ""),
        ("parameters", "A is the amplitude of the excitation", "F(t)",
            "F(t)/(mL) = A sin Ωt: A is in rad/s²", "corrected", ""),
    )  # fmt: skip
    statements = tuple(Statement(NOTEBOOK, *entry) for entry in texts)
    rows = tuple(row(f"{s.place}: {s.text}", s.said, s.ours, judged(s)) for s in statements)
    runs = tuple(
        row(label, value(entry.largest), value(entry.in_runs))
        for label, entry in (("1", small), ("2", large), ("5", damped))
    )
    return Finding(
        "notebook-claims",
        "The notebook's statements: “similar” holds for the first seconds only",
        "corrected",
        "The linear pendulum stands for a pendulum for a few seconds only, even at small "
        "angles. "
        f"In case 1 the two pendulums drift {number(small.largest)} rad apart within "
        f"{DURATION:g} s, {number(100 * small.relative, 2)} % of the amplitude, because their "
        "periods differ by a fraction θ₀²/16.",
        (
            "The exact motions are compared, and beside them the notebook's own runs of RK4 at "
            "0.05 s. In case 5 the swing dies out before the two periods tell.",
        ),
        (
            Table("Statements of the notebook", ("statement", "notebook", "exact", "verdict"),
                  rows),
            Table("Largest |linear less non-linear| [rad]", ("case", "exact", "notebook's RK4"),
                  runs),
        ),
        (_figure(study),),
        tuple(f"plumbob run {kind}free-small ode/rk4 --step 0.05" for kind in (SIMPLE, LINEAR)),
        statements,
    )  # fmt: skip


def _figure(study: Study) -> Figure:
    name = "free-small"
    apart = angle(SIMPLE + name) - angle(LINEAR + name)
    kept = slice(None, None, 10)
    traces: list[Trace] = [curve(TIMES[kept], apart[kept], colour=BLUE, name="exact")]
    nonlinear, linear_run = (study.recording(own_run(kind + name)) for kind in (SIMPLE, LINEAR))
    if nonlinear is not None and linear_run is not None:
        gap = nonlinear.observables["theta"] - linear_run.observables["theta"]
        traces.append(marks(nonlinear.times[::5], gap[::5], GREY, "notebook's RK4", size=3.5))
    return over_time(
        "Case 1: non-linear less linear angle",
        "The difference grows with time, as the phases part.",
        traces,
        linear("Δθ [rad]"),
        height=300,
    )
