"""The finding on special functions and Fourier series: the source's statements on both,
measured."""

from __future__ import annotations

from functools import cache

import numpy as np

from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.pendulums.harmonics import needed
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.cone_pendulum.action_phase import SHALLOW, started
from plumbob.reports.analyses.cone_pendulum.hamiltonian import RESTING, ROTATING, forms
from plumbob.reports.view.content import Figure, Finding, Table, method_cell, row, value
from plumbob.reports.view.notation import number, seconds
from plumbob.reports.view.palette import BLUE, GREEN, ORANGE, RED
from plumbob.reports.view.traces import Trace, curve, figure, linear, logarithmic

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
COLOURS = (BLUE, GREEN, ORANGE, RED)
NEAREST = 1e-9  # of the distance to a separatrix at which the figure begins
EXACT, STEPPED, ADAPTIVE = "exact/closed-form", "mujoco/rk4", "ode/dop853"


@cache
def counts(above: float) -> tuple[int, ...]:
    """Harmonics for ACCURACIES of a rotation of the source's cone on its turning platform, with an
    energy `above` the barrier [J]."""
    problem = started(SHALLOW, 1.0)
    motion = PendulumMotion(
        problem.potential, problem.body.inertia_x, problem.theta, 1.0, excess=above
    )
    return needed(motion, ACCURACIES)


def barrier() -> float:
    """The height of the barrier [J] over the deepest well, a scale of energies."""
    problem = started(SHALLOW, 1.0)
    lowest = min(e.potential for e in problem.equilibria)
    return float(double(problem.motion.barriers[0])) - lowest


def finding(study: Study) -> Finding:
    """A closed form that the source says does not exist, and the series that it recommends."""
    rows = []
    for scene in (RESTING, ROTATING):
        motion = forms(scene).correct
        harmonics = needed(motion, ACCURACIES)
        rows.append(row(scene, value(motion.period, 6), *(str(n) for n in harmonics)))
    near = [(f"{e:g} of the well's depth above the barrier", e) for e in (1e-3, 1e-6, 1e-9)]
    rows += [row(text, "", *(str(n) for n in counts(part * barrier()))) for text, part in near]
    last = counts(1e-9 * barrier())[-1]
    many = needed(forms(ROTATING).correct, ACCURACIES)[-1]
    return Finding(
        "special-functions",
        "The integrals (15), (16) have a closed form; Fourier series need ever more terms",
        "refuted",
        "Compute the exact motion in closed form and not by Fourier series, which near the "
        "barrier need ever more terms. "
        f"With u = tan(θ/2) the time (16) is an elliptic integral of the first kind, and θ(t) "
        f"follows from Jacobi functions. A Fourier series to 1e-12 takes {many} harmonics on the "
        f"motion of Fig. 3 and {last} just above the barrier.{_faster(study)}",
        (
            "The source says that the integrals cannot be written in elementary functions and that "
            "no special functions suit them. The substitution u = tan(θ/2) makes the square root "
            "of (15) that of a quartic in u: a real Möbius map brings it to Legendre's form. The "
            "closed form is the reference of every scene here; it is held to 40-digit quadrature "
            "at 1e-13 rad, in every regime.",
            "It also says that Fourier series are simpler and more exact. Their coefficients fall "
            "geometrically, at a rate Ω times the distance of the nearest singularity in complex "
            "time: far from a separatrix a few terms do, near one their number grows with the "
            "period. And the coefficients have to be found first, for which one needs the motion.",
        ),
        (
            Table(
                "Harmonics of θ(t) for an accuracy",
                ("motion", "period [s]", *(f"{accuracy:g}" for accuracy in ACCURACIES)),
                tuple(rows),
            ),
            _speed(study),
        ),
        (_figure(),),
        (f"plumbob run {ROTATING} {EXACT} --step 2.3e-16", f"plumbob solve {ROTATING}"),
    )


def _faster(study: Study) -> str:
    """A sentence on the cost of a sample beside that of MuJoCo's step, where both were measured."""
    exact, stepped = (study.costs.get((ROTATING, name)) for name in (EXACT, STEPPED))
    if exact is None or stepped is None:
        return ""
    spent, step = (seconds(cost.ns_per_step * 1e-9) for cost in (exact, stepped))
    return f" A sample of the closed form costs {spent}, one step of {STEPPED} {step}."


def _speed(study: Study) -> Table:
    """The measured cost of the closed form, beside that of a step."""
    rows = []
    for scene in (RESTING, ROTATING):
        for method, of in ((EXACT, "a sample"), (STEPPED, "a step"), (ADAPTIVE, "an evaluation")):
            cost = study.costs.get((scene, method))
            spent = "–" if cost is None else seconds(cost.ns_per_step * 1e-9)
            rows.append(row(scene, method_cell(method), of, spent))
    return Table(
        "What the closed form costs, in this study",
        ("scene", "method", "of", "cost"),
        tuple(rows),
        note="The closed form takes no steps: one sample, however late, costs the same.",
    )


def _figure() -> Figure:
    """Harmonics against the energy above the barrier."""
    parts = np.geomspace(NEAREST, 10.0, 41)
    harmonics = np.array([counts(float(part) * barrier()) for part in parts])
    traces: list[Trace] = [
        curve(parts, harmonics[:, i], colour=colour, name=f"to {accuracy:g}")
        for i, (accuracy, colour) in enumerate(zip(ACCURACIES, COLOURS, strict=True))
    ]
    return figure(
        "Fourier series: harmonics for an accuracy, up to the separatrix",
        f"Rotation at ω = 26 rad/s; energy above the barrier, over the {number(barrier())} J of "
        "the deepest well. On the left the separatrix.",
        traces,
        logarithmic("(H – barrier) / depth"),
        linear("harmonics of θ(t) – Ωt [number]"),
        legend=True,
    )
