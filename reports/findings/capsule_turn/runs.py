"""Errors of the body angle that the findings on turns share, at 2 tau and at rest."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Literal

import numpy as np

from plumbob.analytic.systems.manoeuvres.turn_manoeuvre import TurnManoeuvre
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.order import fit_order
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.models.tripod_capsule.turn import EPSILONS, PARTS
from plumbob.reports.findings.capsule.runs import measured, run
from plumbob.reports.findings.capsule.runs import problem as problem_of

When = Literal["stop", "rest"]
METHODS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/rk4+coulomb", "pymunk/feet")
JUDGED = 800  # steps in a half time at which the bar is held
QUICK = (0.3, 0.03)  # the turns of the quick profile


def name_of(epsilon: float) -> str:
    """The scene of a turn until all is at rest."""
    return f"capsule-turn/{epsilon}"


@cache
def turn(epsilon: float) -> TurnManoeuvre:
    """The check manoeuvre with tau = epsilon T."""
    found = problem_of(name_of(epsilon)).motion.manoeuvre
    assert isinstance(found, TurnManoeuvre)
    return found


@cache
def facts(epsilon: float) -> Mapping[str, float]:
    """Angles of the exact motion and of the formulas."""
    scene = find_scene(name_of(epsilon))
    return system_of(scene).facts(problem_of(scene.name))


def epsilons(study: Study) -> tuple[float, ...]:
    """The turns that a profile looks at, large epsilon first."""
    return EPSILONS if study.profile == "full" else QUICK


def seen(
    study: Study, epsilon: float, method: str, parts: int, when: When = "rest"
) -> Measurement | None:
    """What a study measured of a turn until it rests, or until 2 tau, with tau/`parts`."""
    name = name_of(epsilon) + ("-stop" if when == "stop" else "")
    return measured(study, name, method, turn(epsilon).half_time / parts)


def angle_off(
    study: Study, epsilon: float, method: str, parts: int, when: When, *, own: bool = False
) -> float | None:
    """Error of the body angle [rad] at 2 tau or at rest with a step of tau/`parts`, from the study,
    or with `own` from a run of its own; None without either."""
    if (found := seen(study, epsilon, method, parts, when)) is not None:
        return found.errors["body_angle"].end
    if not own:
        return None
    tau = turn(epsilon).half_time
    if (moved := run(name_of(epsilon), method, tau / parts)) is None:
        return None
    at = int(np.argmin(np.abs(moved.times - 2.0 * tau))) if when == "stop" else -1
    exact = facts(epsilon)["body_angle" if when == "stop" else "body_angle_at_rest"]
    return float(moved.observables["body_angle"][at]) - exact


def order_of(study: Study, epsilon: float, method: str, when: When) -> float | None:
    """Observed order of that error over the finest steps of the study, six at most; None from
    fewer than four."""
    errors = [angle_off(study, epsilon, method, parts, when) for parts in PARTS]
    known = [(1.0 / parts, abs(e)) for parts, e in zip(PARTS, errors, strict=True) if e is not None]
    if not known:
        return None
    steps, sizes = zip(*known, strict=True)
    found = fit_order(steps, sizes, [0.0] * len(sizes))
    return None if found is None else found.slope
