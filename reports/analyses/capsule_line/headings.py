"""Errors of a slide over all headings: a scene that is turned as a whole should slide as far."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clearly_larger
from plumbob.reports.analyses.measurements import CHECK_LINE, end_error, recordings

DEFAULT_CONTACTS, RECOMMENDED_CONTACTS = "mujoco/euler", "mujoco/euler+coulomb"
METHODS = (DEFAULT_CONTACTS, "mujoco/euler+elliptic", RECOMMENDED_CONTACTS, "pymunk/feet")
COMPARED_HEADINGS = tuple(range(0, 360, 5))  # [degrees] headings
HEADINGS_STEP = 1e-3  # [s]
# decimals of relative errors that are compared: symmetric headings agree to more
ERROR_DECIMALS = 9
ALIKE_AT_ALL = 1e-4  # relative spread of the displacement below which headings count as equal


def heading_runs(plan: StudyPlan) -> Sequence[ExtraRun]:
    """Returns a run along every heading with every compared method."""
    return [_turned_run(*pair) for pair in product(METHODS, COMPARED_HEADINGS)]


def isotropy(study: Study) -> Record | None:
    """Returns the relative error of the displacement at each heading, and its spread over headings;
    None if no method ran along every heading."""
    by_method = {name: _errors_over_headings(study, name) for name in METHODS}
    default = by_method[DEFAULT_CONTACTS]
    recommended = by_method[RECOMMENDED_CONTACTS]
    complete = tuple(errors for errors in by_method.values() if errors)
    if not complete:
        return None
    return Record(
        angles=COMPARED_HEADINGS,  # [degrees]
        step=HEADINGS_STEP,  # [s]
        every=complete,
        # headings with the smallest and the largest error with default contacts
        best=_heading(default.errors, np.argmin) if default else None,
        worst=_heading(default.errors, np.argmax) if default else None,
        default_spread=default.spread if default else None,
        recommended_spread=recommended.spread if recommended else None,
        # largest magnitude of an error with recommended contacts
        recommended=recommended.errors.max() if recommended else None,
    )


def _turned_run(method: str, angle: int) -> ExtraRun:
    """Returns the run of the scene that is turned by an angle [degrees]."""
    turned = (("heading", math.radians(angle)),)
    return ExtraRun(CHECK_LINE, method, HEADINGS_STEP, changes=turned, end_alone=True)


def _errors_over_headings(study: Study, method: str) -> Record | None:
    """Returns a method's errors over the headings, also as points around a circle; None if the
    method did not run along every heading."""
    runs = recordings(study, [_turned_run(method, angle) for angle in COMPARED_HEADINGS])
    if len(runs) < len(COMPARED_HEADINGS):
        return None
    errors = np.abs([end_error(CHECK_LINE, run) for run in runs.values()])
    closed_circle = np.radians([*COMPARED_HEADINGS, 360])
    radii = 100.0 * np.append(errors, errors[0])
    ahead = radii * np.cos(closed_circle)
    aside = radii * np.sin(closed_circle)
    return Record(
        method=method,
        errors=errors,
        spread=np.ptp(errors),
        ahead=ahead,  # [%] error times the cosine of the heading
        aside=aside,  # [%] error times the sine of the heading
    )


def _heading(errors: Array, end: Callable[[Array], np.intp]) -> Record:
    """Returns the heading with the smallest or the largest error, as `end` (argmin or argmax) says.
    Among headings whose errors differ by rounding, the first one is returned."""
    index = int(end(np.round(errors, ERROR_DECIMALS)))
    angle = COMPARED_HEADINGS[index]
    return Record(
        angle=angle,  # [degrees]
        size=errors[index],  # magnitude of the relative error
        # [degrees] angle to the nearest axis of the friction pyramid
        off_axis=abs((angle + 45) % 90 - 45),
    )


def _differs(numbers: Record) -> Claims:
    """Returns the check that the spread with default contacts exceeds that with recommended
    ones."""
    default = numbers.default_spread
    recommended = numbers.recommended_spread
    if default is None or recommended is None:
        return ()
    text = "the spread over headings, with default contacts and with those recommended"
    return (clearly_larger(text, default, max(recommended, ALIKE_AT_ALL)),)


ISOTROPY = Analysis("capsule_line/isotropy", isotropy, heading_runs, _differs)
