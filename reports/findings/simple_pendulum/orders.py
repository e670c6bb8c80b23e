"""Observed orders against what theory says of each observable on each motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import floor
from plumbob.engines.study.order import Order, fit_order
from plumbob.engines.study.results import Study
from plumbob.reports.findings.simple_pendulum.problems import (
    CASES,
    FORCED,
    SIMPLE,
    convergence,
    order_text,
)
from plumbob.reports.view.content import Cell, Finding, Table, row

METHODS = ("ode/rk4", "ode/leapfrog", "mujoco/euler", "pymunk/default", "pymunk/tight")
REACH = 0.5  # nonlinearity above which an error is no longer a series in the step
Pair = tuple[Order, Order]


def finding(study: Study) -> Finding | None:
    """Orders of five methods on the study's scenes; None where it fitted none."""
    known = convergence(study)
    names = [name for _, name, _ in CASES] + list(FORCED)
    found = {
        n: {m: _fitted(c) for m in METHODS if (c := known.get((SIMPLE + n, m)))} for n in names
    }
    shown = {n: own for n, own in found.items() if any(own.values())}
    if not shown:
        return None
    methods = [m for m in METHODS if any(m in own for own in shown.values())]
    table = Table(
        "Observed order of the error of θ [95 % interval], and below it what is predicted",
        ("scene", *methods),
        tuple(row(name, *_cells(own, methods)) for name, own in shown.items()),
        "Prediction: the same fit to C₁h + C₂h² + … at the same steps. A dash: fewer than four steps "
        "above round-off and within reach of the series; the full profile takes finer ones.",
    )
    return Finding(
        "orders",
        "The order belongs to the motion: RK4 is of order 4 or 5, pymunk of order 1 for a reason",
        "confirmed",
        f"Fitted over four steps or more, the orders are those that theory predicts of this error "
        f"on this motion{_worst(shown)}.",
        (
            "RK4 errs by C₄h⁴ + C₅h⁵ + …. The first term makes the energy come and go; by time "
            "symmetry it has no part in its drift. The h⁵ term drifts: the speed is off by more "
            "and more, and the angle by the square of the time. It rules cases 2 to 4 at the steps "
            "that a user takes. Where the swing is small C₅ is small, and where something damps "
            "nothing piles up: order 4. Leapfrog, symmetric, has even powers only.",
            "pymunk moves its bodies first and solves the joint's velocities after. As it comes, a "
            "joint closes at 6.3/s (error_bias 0.9⁶⁰): while the bob turns it stays open by about "
            "h (dθ/dt)² L/13, the rod is longer by that, and the pull of the closing joint takes "
            "energy; both are of first order in h, and so is the error. With error_bias 0 "
            "(pymunk/tight) it closes in one step: what is left is the error of Euler's step, and "
            "an opening of second order. The number of iterations changes nothing: one joint is "
            "solved exactly at once.",
        ),
        (table,),
        (),
        tuple(
            f"plumbob validate --profile full --scenes {SIMPLE}{name} --methods {','.join(methods)}"
            for name in list(shown)[:2]
        ),
    )


def _fitted(found: ConvergenceStudy) -> Pair | None:
    """Observed and predicted order of the error of theta, over the steps that the series reaches;
    None with fewer than four of them above round-off."""
    reached = [
        (m.step, m.errors["theta"], floor(m.errors["theta"], m.steps))
        for m in found.measurements
        if m.status == "done" and (f := m.errors["theta"].predicted) and f.nonlinearity < REACH
    ]
    if not reached:
        return None
    steps, errors, floors = zip(*reached, strict=True)
    observed = fit_order(steps, [e.largest for e in errors], floors)
    if observed is None:
        return None
    same = [
        e.predicted.largest
        for h, e in zip(steps, errors, strict=True)
        if h in observed.steps and e.predicted
    ]
    told = fit_order([h for h in steps if h in observed.steps], same, [0.0] * len(same))
    return (observed, told) if told else None


def _cells(own: Mapping[str, Pair | None], methods: Sequence[str]) -> list[Cell]:
    cells = []
    for method in methods:
        if (pair := own.get(method)) is None:
            cells.append(Cell("–", "number", "too few steps that the series reaches"))
            continue
        text = f"{order_text(pair[0])}\n{pair[1].slope:.3f}"
        cells.append(Cell(text, "number", "observed, then predicted"))
    return cells


def _worst(shown: Mapping[str, Mapping[str, Pair | None]]) -> str:
    pairs = [pair for own in shown.values() for pair in own.values() if pair]
    gap = max(abs(observed.slope - told.slope) for observed, told in pairs)
    return f", to {gap:.3f} at worst"
