"""The friction with which an engine slides as far as the exact motion, beside the true one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import MappingProxyType

from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.identification import ParameterFit
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.capsule_line.headings import DEFAULT, RECOMMENDED, STEP
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.measurements import LINE

# [degrees]: a quarter of all, mirrored; with contacts that are isotropic two of them
ANGLES = MappingProxyType({DEFAULT: (0, 15, 30, 45), RECOMMENDED: (0, 30)})
PAIRS = tuple((method, angle) for method, angles in ANGLES.items() for angle in angles)
SEARCHED = (0.15, 0.6)  # from half of the scene's friction to twice it
BUDGET = 40  # runs: the fit is then closer than 1e-4
ALIKE = 1e-3  # of the friction: fits that differ by less do not tell


def requests(plan: StudyPlan) -> Sequence[ParameterFit]:
    """A fit for each heading in both methods."""
    return [_fit(*pair) for pair in PAIRS]


def numbers(study: Study) -> Record | None:
    """The fits that a study holds; None where it holds none."""
    fits = []
    exact = math.nan
    for method, angle in PAIRS:
        fit = study.answer(_fit(method, angle))
        if fit:
            (parameter,) = fit.parameters
            exact = parameter.true
            bias = parameter.identified / parameter.true - 1.0
            fits.append(
                Record(
                    method=method,
                    angle=angle,  # [degrees]
                    friction=parameter.identified,
                    bias=bias,  # relative
                    residual=fit.residual,  # of the displacement, relative
                )
            )
    if not fits:
        return None
    default = [fit for fit in fits if fit.method == DEFAULT]
    biases = [abs(fit.bias) for fit in fits if fit.method == RECOMMENDED]
    return Record(
        exact=exact,
        step=STEP,  # [s]
        fits=fits,
        # the most biased fit with default contacts
        worst=max(default, key=lambda fit: abs(fit.bias), default=None),
        # a bound of the bias with the recommended contacts: the search begins with the true value
        recommended=max([ALIKE, *biases]) if biases else None,
    )


def claims(numbers: Record) -> Claims:
    """That default contacts bias the friction that is identified, and the recommended do not."""
    if numbers.worst is None or numbers.recommended is None:
        return ()
    text = (
        "the bias of the identified friction, with default contacts and with those recommended"
    )
    return (clear(text, abs(numbers.worst.bias), numbers.recommended),)


def _fit(method: str, angle: int) -> ParameterFit:
    turned = (("heading", math.radians(angle)),)
    return ParameterFit(LINE, method, STEP, "friction", *SEARCHED, BUDGET, turned)


IDENTIFIED = Analysis("capsule_line/identified", numbers, requests, claims)
