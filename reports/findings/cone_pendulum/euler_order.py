"""The finding that Euler is of second order on a resting base: nothing pushes at the start."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.errors.pendulum_errors import PendulumErrors
from plumbob.analytic.errors.schemes import EULER, Scheme
from plumbob.engines.study.study import Study
from plumbob.reports.findings.cone_pendulum.problems import RESTING, ROTATING, case
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Finding, Table, row

SCHEME = Scheme(EULER)
METHOD = "mujoco/euler"


def finding(study: Study) -> Finding:
    """The leading coefficients on both bases, and the orders that the study saw."""
    rows, first = [], {}
    for name in (RESTING, ROTATING):
        problem = case(name).problem
        rotor = problem.motion.rotor
        duration = next((s.duration for s in study.scenes if s.name == name), 0.5)
        times = np.linspace(0.0, duration, 200)
        terms = PendulumErrors(problem.motion).series(SCHEME, times)
        size = {p: float(np.abs(terms[p]["theta"]).max()) for p in (1, 2)}
        first[name] = size[1]
        push = float(rotor.acceleration(0.0, problem.theta, problem.theta_dot))
        convergence_study = next(
            (c for c in study.convergence if (c.scene, c.method) == (name, METHOD)), None
        )
        seen = convergence_study.order if convergence_study else None
        told = f"{seen.slope:.3f} [{seen.low:.3f}, {seen.high:.3f}]" if seen else "not measured"
        numbers = (push, size[1], size[2])
        rows.append(row(name, *(Cell(notation.number(v, 4), "number") for v in numbers), told))
    heads = ("scene", "a(θ₀) [rad/s²]", "largest |C₁| [rad/s]", "largest |C₂| [rad/s²]",
             f"observed order of {METHOD}")  # fmt: skip
    return Finding(
        "euler-order",
        "Euler is of second order from the bottom on a resting base",
        "confirmed",
        f"Semi-implicit Euler is leapfrog with the velocity shifted by half a step. The shift is "
        f"½h a(θ₀), and hanging straight down a(θ₀) = 0 on a resting base: the first-order term C₁ "
        f"{_size(first[RESTING], first[ROTATING])} there and is {notation.number(first[ROTATING])} "
        f"rad/s on the turning one.",
        (
            "The order of a method is thus a statement about a motion and an observable as well: a "
            "test that starts at the bottom of a swing would certify a first-order integrator as "
            "second order.",
        ),
        (Table("Leading coefficients, error = C₁h + C₂h² + …", heads, tuple(rows)),),
        (),
        (f"plumbob validate --scenes {RESTING},{ROTATING} --methods {METHOD}",),
    )


def _size(value: float, beside: float) -> str:
    return "vanishes" if value < 1e-9 * beside else f"is {notation.number(value)} rad/s"
