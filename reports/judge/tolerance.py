"""Tolerances of runs. Each is a sum of named terms, each with its reason; none is a number that was
chosen because the runs pass it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from sys import float_info

from plumbob.analytic.left_open import nonlinear_part
from plumbob.analytic.schemes import ADAPTIVE
from plumbob.analytic.theory import reaches
from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement, ObservedError, floor, rounding_bound
from plumbob.models.scene import Quantity

STARTS_OFF = "the run does not start where the scene does"
# Largest error at the start, relative to an observable's size. An engine in single precision rounds
# by 6e-8.
START_ERROR = 1e-6
# Largest error at the start, in the observable's unit: a small angle is read off an attitude, whose
# numbers are near one.
START_ROUNDING = 1e-15
TOO_WIDE = "the model-error bound"
MODEL_FRACTION = 2.5e-3
"""Largest model-error bound of an engine at the finest step, relative to a quantity of interest.
One per cent of friction, or of a mass, moves a capsule by four times as much."""

AT_STEP = "discretisation"  # name of the term that theory predicts to the last digit


# Patterns of scene names, with a fraction that replaces MODEL_FRACTION.
MODEL_FRACTIONS = (
    ("*-pendulum/*", 1e-8),  # a joint: the bob's inertia adds less than rounding does
    ("free-body/*", 1e-8),  # one body that nothing touches: the model adds nothing
    ("capsule-line/w1-threshold*", 0.5),  # the body moves by 1.3 nm in all
    ("capsule-turn/held*", 0.2),  # friction holds the body for most of the turn
    ("capsule-turn/pivot*", 5e-3),  # a support sticks while the body pivots about it
    ("capsule-turn/thousand", 0.3),  # bounds of a thousand turns add up, in one radian
    # Plans have many short manoeuvres, and a profile runs them at coarse steps alone. The body of
    # heavy-slider weighs a thousandth of its slider.
    ("capsule-plan/near-free", 0.015),
    ("capsule-plan/heavy-slider", 0.5),
    ("capsule-plan/*", 0.2),
)


@dataclass(frozen=True)
class ToleranceTerm:
    """One term of a tolerance."""

    name: str
    value: float
    reason: str


@dataclass(frozen=True)
class Tolerance:
    """A bound on the error of one observable, in its unit, as a sum of terms."""

    unit: str
    terms: tuple[ToleranceTerm, ...]

    @property
    def bound(self) -> float:
        """The sum of the terms."""
        return sum(term.value for term in self.terms)


def tolerance(run: Measurement, method: Method, observable: str, unit: str) -> Tolerance | None:
    """Returns the tolerance of one observable in one run; None if theory does not reach the step.
    Theory does not reach a step if the last two terms of the expansion are more than a tenth of it,
    if the response is nonlinear, or if an adaptive solver has no second run for comparison."""
    error = run.errors[observable]
    if method.control == "tolerance":
        step_terms: tuple[ToleranceTerm, ...] | None = _adaptive_terms(error, method)
    else:
        step_terms = _prediction_terms(error, run.step)
    if step_terms is None:
        return None
    model_terms = tuple(
        ToleranceTerm(
            f"regularisation: {name}", value, "the model differs from the equations by this"
        )
        for name, value in error.model.items()
    )
    return Tolerance(unit, (*step_terms, *model_terms, *_rounding_terms(error, run.steps)))


def used_fraction(error: ObservedError, allowed: Tolerance) -> float:
    """Returns the fraction of its tolerance that an error uses; above 1 if the error fails. If the
    error is predicted, the fraction refers to the difference from the prediction; otherwise to the
    error itself."""
    controlled = error.controlled
    if controlled is not None and controlled.beyond > 0.0:
        return 1.0 + controlled.beyond / max(error.largest, controlled.largest)
    predicted = error.predicted
    left_open = error.left_open
    if predicted is None or not left_open:
        return error.largest / allowed.bound if allowed.bound else float(error.largest > 0.0)
    excess = predicted.beyond - error.model_error
    if excess > 0.0:
        return 1.0 + excess / left_open
    return min(predicted.difference / left_open, 1.0)


def prediction_mismatch(error: ObservedError, unit: str) -> str | None:
    """Message if an error is not the predicted one; None if it is. At every sample the signed error
    may differ from the prediction by the bound of the model error and by what theory leaves open
    there: the remainder of the series, and rounding. The error of an adaptive solver must stay
    within its distance from a run with a much smaller tolerance."""
    controlled = error.controlled
    if controlled is not None and controlled.beyond > 0.0:
        bound = "the bound by a run with a much smaller tolerance"
        return f"{controlled.beyond:.3g} {unit} above {bound}"
    predicted = error.predicted
    if predicted is None or predicted.beyond <= error.model_error:
        return None
    difference = f"{predicted.difference:.3g} {unit} from its prediction"
    return f"{difference}, allowed {error.left_open:.3g}"


def start_mismatch(run: Measurement) -> str:
    """Message if the first sample is not the start of the scene; empty if it is. An observable that
    is zero throughout has no size: its tolerance alone judges it."""
    for name, error in run.errors.items():
        allowed = START_ERROR * error.scale + error.uncertainty + START_ROUNDING
        if error.scale > 0.0 and error.start > allowed:
            return f"{STARTS_OFF}: {name} differs by {error.start:.3g}, allowed {allowed:.3g}"
    return ""


def wide_model_bound(run: Measurement, quantities: Sequence[Quantity]) -> str:
    """Message if an engine's own model-error bound exceeds the scene's allowed fraction of the
    motion: so wide a bound hides other errors. Empty if it does not, or if rounding hides as
    much."""
    allowed = model_fraction(run.scene)
    for quantity in quantities:
        error = run.errors.get(quantity.observable)
        if error is None or error.model_error <= rounding_bound(error, run.steps):
            continue
        fraction = error.model_error / quantity.scale
        if fraction > allowed:
            return (
                f"{TOO_WIDE} of {quantity.observable} is {fraction:.3g} of its scale at the "
                f"finest step, allowed {allowed:g}"
            )
    return ""


def model_fraction(scene: str) -> float:
    """Returns the largest model-error bound allowed for a scene, as a fraction of a quantity of
    interest. `scene` is the scene's name."""
    for pattern, fraction in MODEL_FRACTIONS:
        if fnmatchcase(scene, pattern):
            return fraction
    return MODEL_FRACTION


def tolerance_excess(
    run: Measurement, name: str, allowed: Tolerance, units: Mapping[str, str]
) -> str | None:
    """Message if the error of an observable is not within its tolerance; None if it is. An
    observable that is exactly zero throughout, as the heading on a line, may differ from zero by
    rounding."""
    error = run.errors[name]
    if error.scale == 0.0 and error.largest <= round_off(run, name, units):
        return None
    if not error.largest <= allowed.bound:
        return f"{error.largest:.3g} {allowed.unit}, allowed {allowed.bound:.3g}"
    return prediction_mismatch(error, allowed.unit)


def round_off(run: Measurement, name: str, units: Mapping[str, str]) -> float:
    """Returns the round-off level of an error, in the unit of the observable. The level scales with
    the largest observable of the same unit. If the observable stays zero, it scales with the
    largest of all observables."""
    error = run.errors[name]
    if error.scale:
        same_unit = [other for other in run.errors if units.get(other) == units.get(name)]
        scale = max(run.errors[other].scale for other in same_unit)
    else:
        scale = max(other.scale for other in run.errors.values())
    uncertainty = max(error.uncertainty, float_info.epsilon * scale)
    return floor(replace(error, model={}, uncertainty=uncertainty), run.steps)


def _prediction_terms(error: ObservedError, step: float) -> tuple[ToleranceTerm, ...] | None:
    """Returns the terms of a predicted error; None without a prediction, or if the series does not
    reach this step."""
    predicted = error.predicted
    if predicted is None:
        return None
    if predicted.for_this_step:
        reason = f"error of the scheme on this motion at this step, h = {step:g} s"
        return (ToleranceTerm(AT_STEP, predicted.largest, reason),)
    terms = predicted.terms
    if not reaches(terms, predicted.largest, predicted.nonlinearity):
        return None
    powers = sorted(terms)
    last_two = sum(terms[power] for power in powers[-2:])
    nonlinear = nonlinear_part(terms, predicted.nonlinearity) * predicted.largest
    series = " + ".join(f"C{power} h^{power}" for power in powers)
    discretisation = ToleranceTerm(
        "discretisation",
        predicted.largest,
        f"{series} of the scheme on this motion, h = {step:g} s",
    )
    remainder = ToleranceTerm(
        "discretisation: remainder",
        last_two + nonlinear,
        "the rest of the series is smaller than its last two terms and the first nonlinear "
        "term that the series leaves out",
    )
    return discretisation, remainder


def _adaptive_terms(error: ObservedError, method: Method) -> tuple[ToleranceTerm, ...] | None:
    """Returns the term of a solver that controls its local error; none for a closed form; None if
    the solver has no second run for comparison."""
    controlled = error.controlled
    if controlled is None:
        # A closed form takes no steps, and needs no term.
        return None if method.scheme.integrator == ADAPTIVE else ()
    reason = "twice its distance from a run on the same equations with a much smaller tolerance"
    return (ToleranceTerm("local error control", controlled.largest, reason),)


def _rounding_terms(error: ObservedError, steps: int) -> tuple[ToleranceTerm, ...]:
    """Returns the terms for the rounding of the inputs and of each of the `steps` steps."""
    predicted = error.predicted
    if predicted is not None and predicted.uncertainty is not None:
        uncertainty = predicted.uncertainty
        answer = "answer of this step"
    else:
        uncertainty = error.uncertainty
        answer = "exact answer"
    conditioning = ToleranceTerm(
        "conditioning",
        uncertainty,
        f"one unit in the last place of every input moves the {answer} by this",
    )
    random_walk = ToleranceTerm(
        "round-off",
        2.0 * steps**0.5 * uncertainty,
        "each step's rounding, half an ulp, in a random walk: four standard deviations",
    )
    return conditioning, random_walk
