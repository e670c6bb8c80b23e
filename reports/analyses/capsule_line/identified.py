"""The friction coefficient identified with an engine, beside the true one. With the identified
friction, the engine's body slides as far as the exact motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import MappingProxyType

from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.identification import ParameterFit
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_line.headings import (
    DEFAULT_CONTACTS,
    HEADINGS_STEP,
    RECOMMENDED_CONTACTS,
)
from plumbob.reports.analyses.claims import Claims, clearly_larger
from plumbob.reports.analyses.measurements import CHECK_LINE

# [degrees] headings of the fits. Symmetry leaves an eighth of the circle for default contacts; two
# headings are enough for isotropic contacts.
FIT_HEADINGS = MappingProxyType(
    {DEFAULT_CONTACTS: (0, 15, 30, 45), RECOMMENDED_CONTACTS: (0, 30)}
)
METHODS_AND_HEADINGS = tuple(
    (method, angle) for method, angles in FIT_HEADINGS.items() for angle in angles
)
SEARCHED = (0.15, 0.6)  # search range: from half of the scene's friction to twice it
FIT_RUNS = 40  # number of runs; the friction is then within 1e-4 of the best fit
EQUAL_FRICTION_BIAS = 1e-3  # relative bias of the friction below which fits count as equal


def requests(plan: StudyPlan) -> Sequence[ParameterFit]:
    """Returns a fit of the friction for each heading with both methods."""
    return [_fit(*pair) for pair in METHODS_AND_HEADINGS]


def numbers(study: Study) -> Record | None:
    """Returns the identified friction coefficients and their biases; None if the study holds no
    fit."""
    fits = []
    exact = math.nan
    for method, angle in METHODS_AND_HEADINGS:
        fit = study.answer(_fit(method, angle))
        if not fit:
            continue
        (parameter,) = fit.parameters
        exact = parameter.true
        row = Record(
            method=method,
            angle=angle,  # [degrees]
            friction=parameter.identified,
            bias=parameter.identified / parameter.true - 1.0,  # relative
            residual=fit.residual,  # relative residual of the displacement
        )
        fits.append(row)
    if not fits:
        return None
    default = [fit for fit in fits if fit.method == DEFAULT_CONTACTS]
    biases = [abs(fit.bias) for fit in fits if fit.method == RECOMMENDED_CONTACTS]
    return Record(
        exact=exact,
        step=HEADINGS_STEP,  # [s]
        fits=fits,
        # the most biased fit with default contacts
        worst=max(default, key=lambda fit: abs(fit.bias), default=None),
        # A search that begins with the true value may end there, so the bias with the recommended
        # contacts is only bounded by EQUAL_FRICTION_BIAS.
        recommended=max([EQUAL_FRICTION_BIAS, *biases]) if biases else None,
    )


def claims(numbers: Record) -> Claims:
    """Returns the check that default contacts bias the identified friction and recommended contacts
    do not."""
    if numbers.worst is None or numbers.recommended is None:
        return ()
    text = (
        "the bias of the identified friction, with default contacts and with those recommended"
    )
    return (clearly_larger(text, abs(numbers.worst.bias), numbers.recommended),)


def _fit(method: str, angle: int) -> ParameterFit:
    """Returns the fit of the friction in the scene that is turned by an angle [degrees]."""
    turned = (("heading", math.radians(angle)),)
    return ParameterFit(
        CHECK_LINE, method, HEADINGS_STEP, "friction", *SEARCHED, FIT_RUNS, turned
    )


IDENTIFIED = Analysis("capsule_line/identified", numbers, requests, claims)
