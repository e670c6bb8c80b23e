"""The engines' body angle over epsilon: errors, their cause, and contact deflection."""

from __future__ import annotations

from plumbob.analytic.errors.sliding_motion.plane_errors import euler_lead
from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS, PARTS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.exact_motion import formulas
from plumbob.reports.analyses.capsule_turn.turns import (
    JUDGED,
    METHODS,
    WHENS,
    epsilons,
    judged_error,
    order_of,
    requests,
    turn,
    turn_run,
)
from plumbob.reports.analyses.claims import Claims, clear

ASKED, FROM = 1e-4, 0.03  # [rad], for epsilon of so much and more
EULER, RK4, FEET, DEFAULT = "mujoco/euler+coulomb", "mujoco/rk4+coulomb", "pymunk/feet", METHODS[0]
Points = tuple[tuple[float, float], ...]  # epsilon and an error [rad]


def angles(study: Study) -> Record | None:
    """Errors at 2 tau and at rest by epsilon and method; None without an engine."""
    rows = [_turn_errors(study, e, name) for e in epsilons(study) for name in METHODS]
    errors = tuple(filter(None, rows))
    if not errors:
        return None
    steps = tuple(_step_errors(study, parts) for parts in (PARTS[0], JUDGED, PARTS[-1]))
    step = turn(0.3).half_time / JUDGED
    formula, corrected = formulas()
    # the largest error [rad] of each method at the epsilons that it is asked for
    judged = [error for error in errors if error.epsilon >= FROM]
    held = {n: [e.largest for e in judged if e.method == n] for n in METHODS}
    return Record(
        errors=errors,
        steps=steps,
        formula=formula,
        corrected=corrected,
        ordered=study.profile == "full",
        step=step,  # [s] at epsilon 0.3
        epsilons=EPSILONS,
        methods=METHODS,
        judged=JUDGED,
        asked=ASKED,
        asked_from=FROM,
        held={name: max(sizes) for name, sizes in held.items() if sizes},
    )


def _turn_errors(study: Study, epsilon: float, name: str) -> Record | None:
    """Errors of the body angle [rad] of one turn and method at 2 tau and at rest, and their
    orders."""
    stop, end = (judged_error(study, epsilon, name, when) for when in WHENS)
    if stop is None or end is None:
        return None
    stop_order, rest_order = (order_of(study, epsilon, name, when) for when in WHENS)
    return Record(
        epsilon=epsilon,
        method=name,
        stop=stop,
        rest=end,
        stop_order=stop_order,
        rest_order=rest_order,
        largest=max(abs(stop), abs(end)),
    )


def _step_errors(study: Study, parts: int) -> Record:
    """At 2 tau by its formula, the same for every epsilon; at rest where the study has it."""
    stop = tuple((e, euler_lead(turn(e)) * turn(e).half_time / parts) for e in EPSILONS)
    runs = [(e, turn_run(study, e, EULER, parts)) for e in epsilons(study)]
    predicted = [(e, run.errors["body_angle"].predicted) for e, run in runs if run]
    return Record(parts=parts, stop=stop, rest=[(e, error.end) for e, error in predicted if error])


def angle_claims(numbers: Record) -> Claims:
    """Euler steps are far less accurate than RK4 and pymunk's feet."""
    held = numbers.held
    return [
        clear(f"the error of {EULER}, and of {name},", held[EULER], held[name], "rad")
        for name in (RK4, FEET)
        if {EULER, name} <= set(held)
    ]


ANGLE = Analysis("capsule_turn/angle", angles, requests, angle_claims)
