"""How far off a run may be: a budget of named terms, each with its reason; never a number that
merely passes."""

from __future__ import annotations

from dataclasses import dataclass

from plumbob.engines.method import Method
from plumbob.engines.study.measurement import Measurement, ObservedError

TRUST = (
    0.1  # an expansion whose last terms, or nonlinear part, are more than this of it is not used
)


AT_STEP = "discretisation"  # the term that is predicted to the last digit, where one is


@dataclass(frozen=True)
class Term:
    """One part of a tolerance."""

    name: str
    value: float
    reason: str


@dataclass(frozen=True)
class Tolerance:
    """A bound on the error of one observable, in its unit, as a sum of terms."""

    unit: str
    terms: tuple[Term, ...]

    @property
    def bound(self) -> float:
        """The sum of the terms."""
        return sum(term.value for term in self.terms)


def tolerance(found: Measurement, method: Method, observable: str, unit: str) -> Tolerance | None:
    """The tolerance of one observable in one run; None where theory does not reach the step (the
    expansion's last two terms, or what is nonlinear in it, is more than a tenth of it) or the
    tolerance (what it allows is more than the motion responds to in proportion)."""
    error = found.errors[observable]
    if method.control == "tolerance":
        step_terms: tuple[Term, ...] | None = _adaptive(error)
    else:
        step_terms = _expansion(error, found.step)
    if step_terms is None:
        return None
    shares = tuple(
        Term(f"regularisation: {name}", value, "the model differs from the equations by this")
        for name, value in error.model.items()
    )
    return Tolerance(unit, (*step_terms, *shares, *_double_precision(error, found.steps)))


def missed(error: ObservedError) -> str | None:
    """Why an error is not what was predicted of it, or None: where theory says it to the last digit,
    no more may be left of it than rounding and the model explain."""
    told = error.predicted
    if told is None or told.missed is None or told.missed <= (allowed := sum(error.model.values())):
        return None
    return f"off what is predicted by {told.missed:.3g}, allowed {allowed:.3g}"


def _expansion(error: ObservedError, step: float) -> tuple[Term, ...] | None:
    told = error.predicted
    if told is None:
        return None
    if told.missed is not None:
        reason = f"what the scheme does to this motion at this step, h = {step:g} s"
        return (Term(AT_STEP, told.largest, reason),)
    # The last two: in a symmetric scheme's neighbour every other term may be small by chance.
    last = sum(told.terms[p] for p in sorted(told.terms)[-2:])
    if told.nonlinearity > TRUST or last > TRUST * told.largest:
        return None
    powers = " + ".join(f"C{p} h^{p}" for p in sorted(told.terms))
    return (
        Term(
            "discretisation", told.largest, f"{powers} of the scheme on this motion, h = {step:g} s"
        ),
        Term(
            "discretisation: remainder",
            last + told.nonlinearity * told.largest,
            "what follows in the series is less than its last two terms; what is nonlinear",
        ),
    )


def _adaptive(error: ObservedError) -> tuple[Term, ...] | None:
    if (may := error.controlled) is None:  # a closed form takes no steps
        return ()
    if may.nonlinearity > TRUST:
        return None
    reason = "every step may err by rtol times the state, and carries it to the end"
    return (Term("local error control", may.largest, reason),)


def _double_precision(error: ObservedError, steps: int) -> tuple[Term, ...]:
    return (
        Term(
            "conditioning",
            error.uncertainty,
            "one unit in the last place of every input moves the exact answer by this",
        ),
        Term(
            "round-off",
            2.0 * steps**0.5 * error.uncertainty,
            "each step's rounding, half an ulp, in a random walk: four standard deviations",
        ),
    )
