"""The engines' body angle over epsilon: errors, their cause, and contact deflection."""

from __future__ import annotations

from plumbob.engines.study.results import Study
from plumbob.models.tripod_capsule.turn import EPSILONS
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_turn.exact_motion import formulas
from plumbob.reports.analyses.capsule_turn.turns import (
    JUDGED,
    METHODS,
    WHENS,
    epsilons,
    judged_error,
    requests,
    turn,
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
    formula, corrected = formulas()
    # the largest error [rad] of each method at the epsilons that it is asked for
    judged = [error for error in errors if error.epsilon >= FROM]
    held = {n: [e.largest for e in judged if e.method == n] for n in METHODS}
    return Record(
        errors=errors,
        formula=formula,
        corrected=corrected,
        step=turn(0.3).half_time / JUDGED,  # [s] at epsilon 0.3
        epsilons=EPSILONS,
        methods=METHODS,
        judged=JUDGED,
        asked=ASKED,
        asked_from=FROM,
        held={name: max(sizes) for name, sizes in held.items() if sizes},
    )


def _turn_errors(study: Study, epsilon: float, name: str) -> Record | None:
    """Errors of the body angle [rad] of one turn and method at 2 tau and at rest."""
    stop, end = (judged_error(study, epsilon, name, when) for when in WHENS)
    if stop is None or end is None:
        return None
    largest = max(abs(stop), abs(end))
    return Record(epsilon=epsilon, method=name, stop=stop, rest=end, largest=largest)


def angle_claims(numbers: Record) -> Claims:
    """Euler steps are far less accurate than RK4 and pymunk's feet."""
    held = numbers.held
    return [
        clear(f"the error of {EULER}, and of {name},", held[EULER], held[name], "rad")
        for name in (RK4, FEET)
        if {EULER, name} <= set(held)
    ]


ANGLE = Analysis("capsule_turn/angle", angles, requests, angle_claims)
