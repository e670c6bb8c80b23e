"""Errors of a slide over all headings: the scene is turned as a whole, and should slide as far."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.measurements import LINE, end_error

DEFAULT, RECOMMENDED = "mujoco/euler", "mujoco/euler+coulomb"
METHODS = (DEFAULT, "mujoco/euler+elliptic", RECOMMENDED, "pymunk/feet")
ANGLES = tuple(range(0, 360, 5))  # [degrees]
STEP = 1e-3  # [s]
DIGITS = 9  # of relative errors: those of symmetric headings agree to more
ALIKE_AT_ALL = 1e-4  # of the displacement: headings that differ by less do not tell


def heading_runs(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Every heading in every method compared."""
    return [_run(*pair) for pair in product(METHODS, ANGLES)]


def isotropy(study: Study) -> Record | None:
    """Relative error of the displacement at each heading, and its spread."""
    every = {name: line for name in METHODS if (line := _over_headings(study, name))}
    if not every:
        return None
    default = every.get(DEFAULT)
    recommended = every.get(RECOMMENDED)
    return Record(
        angles=ANGLES,  # [degrees]
        step=STEP,  # [s]
        every=tuple(every.values()),
        best=_heading(default.errors, np.argmin) if default else None,  # with default contacts
        worst=_heading(default.errors, np.argmax) if default else None,
        default_spread=default.spread if default else None,
        recommended_spread=recommended.spread if recommended else None,
        # the largest size of an error
        recommended=recommended.errors.max() if recommended else None,
    )


def _run(method: str, angle: int) -> ExtraRun:
    turned = (("heading", math.radians(angle)),)
    return ExtraRun(LINE, method, STEP, changes=turned, end_alone=True)


def _over_headings(study: Study, method: str) -> Record | None:
    """The errors of a method; None where it did not run along every heading."""
    runs = [run for a in ANGLES if (run := study.answer(_run(method, a)))]
    if len(runs) < len(ANGLES):
        return None
    errors = np.abs([end_error(LINE, run) for run in runs])
    around = np.radians([*ANGLES, 360])
    radii = 100.0 * np.append(errors, errors[0])
    ahead = radii * np.cos(around)
    aside = radii * np.sin(around)
    return Record(
        method=method,
        errors=errors,
        spread=np.ptp(errors),
        ahead=ahead,  # [%]
        aside=aside,  # [%]
    )


def _heading(errors: Array, end: Callable[[Array], np.intp]) -> Record:
    """The heading at an end of the errors: the first of those that differ by their rounding."""
    place = int(end(np.round(errors, DIGITS)))
    angle = ANGLES[place]
    return Record(
        angle=angle,  # [degrees]
        size=errors[place],  # relative
        # angle to the nearest axis of the friction pyramid [degrees]
        off_axis=abs((angle + 45) % 90 - 45),
    )


def _differs(numbers: Record) -> Claims:
    default = numbers.default_spread
    recommended = numbers.recommended_spread
    if default is None or recommended is None:
        return ()
    text = "the spread over headings, with default contacts and with those recommended"
    return (clear(text, default, max(recommended, ALIKE_AT_ALL)),)


ISOTROPY = Analysis("capsule_line/isotropy", isotropy, heading_runs, _differs)
