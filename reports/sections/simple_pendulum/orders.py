"""Observed orders against what theory says of each observable on each motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from engines.climb import Climb
from engines.study import Study
from reports.content import Cell, Finding, Table, row
from reports.sections.simple_pendulum.problems import CASES, FORCED, SIMPLE, climbs, order_text

METHODS = ("ode/rk4", "ode/leapfrog", "mujoco/euler", "pymunk/default", "pymunk/tight")


def finding(study: Study) -> Finding | None:
    """Orders of five methods on the study's scenes; None where it fitted none."""
    known = climbs(study)
    names = [name for _, name, _ in CASES] + list(FORCED)
    found = {n: {m: c for m in METHODS if (c := known.get((SIMPLE + n, m)))} for n in names}
    shown = {n: own for n, own in found.items() if any(_reached(c) for c in own.values())}
    if not shown:
        return None
    methods = [m for m in METHODS if any(m in own for own in shown.values())]
    table = Table(
        "Observed order of the error of θ [95 % interval], and below it what is foretold",
        ("scene", *methods),
        tuple(row(name, *_cells(own, methods)) for name, own in shown.items()),
        "Foretold: the same fit to C₁h + C₂h² + … at the same steps. A dash: fewer than four steps "
        "above round-off, or not all of them within reach of the series; the full profile takes "
        "finer ones.",
    )
    return Finding(
        "orders",
        "The order belongs to the motion: RK4 is of order 4 or 5, pymunk of order 1 for a reason",
        "confirmed",
        f"Fitted over four steps or more, the orders are those that theory foretells of this error "
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


def _cells(own: Mapping[str, Climb], methods: Sequence[str]) -> list[Cell]:
    cells = []
    for method in methods:
        found = own.get(method)
        order, told = (found.order, found.foretold_order) if found else (None, None)
        if found is not None and order and told and _reached(found):
            text, hint = f"{order_text(order)}\n{told.slope:.3f}", "observed, then foretold"
        else:
            text, hint = "–", "too few steps that the series reaches"
        cells.append(Cell(text, "number", hint))
    return cells


def _worst(shown: Mapping[str, Mapping[str, Climb]]) -> str:
    gaps = [
        abs(c.order.slope - c.foretold_order.slope)
        for own in shown.values()
        for c in own.values()
        if c.order and c.foretold_order and _reached(c)
    ]
    return f", to {max(gaps):.3f} at worst where the series reaches the steps" if gaps else ""


def _reached(found: Climb) -> bool:
    """Whether an order was fitted, and theory reaches every step of the fit."""
    steps = found.order.steps if found.order else ()
    told = [m.errors["theta"].foretold for m in found.measurements if m.step in steps]
    return bool(told) and all(f is not None and f.nonlinearity < 1.0 for f in told)
