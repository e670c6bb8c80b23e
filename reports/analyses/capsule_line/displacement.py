"""The final displacement: each method's error, its explanation, and the sawtooth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clear
from plumbob.reports.analyses.contact_terms import (
    contact_of,
    deflection_term,
    step_term,
    stiction_drift,
)
from plumbob.reports.analyses.measurements import (
    LINE,
    covers,
    measured,
    measured_error,
    names,
    problem,
)

STEPS = (1e-3, 1e-4, 1e-5)
TURNED, TURNED_STEP = "capsule-line/heading-030", 1e-4
FULL, REDUCED = "mujoco/euler+coulomb", "mujoco/euler+reduced"
CONVERGENT = ("coulomb", "coulomb+noslip", "reduced", "feet", "side")  # theory covers these
COMPARED = ("mujoco/euler", FULL, "mujoco/rk4+coulomb", "pymunk/feet")


def errors(study: Study) -> Record | None:
    """Relative errors by method and step, with the terms beside the step's; None where the study
    does not have the scene."""
    if not covers(study, LINE):
        return None
    exact = problem(LINE).motion.displacement
    every = [_errors(study, name) for name in names(study)]
    methods = [method for method in every if any(error is not None for error in method.errors)]
    middle = [(method.method.endswith(CONVERGENT), method.errors[1]) for method in methods]
    good = [abs(error) for converges, error in middle if converges and error is not None]
    bad = [abs(error) for converges, error in middle if not converges and error is not None]
    return Record(
        exact=exact,  # [m]
        predicted=[step_term(LINE, step) / exact for step in STEPS],  # relative, at STEPS
        predicted_turned=step_term(LINE, TURNED_STEP) / exact,
        methods=methods,
        beyond=_beyond_the_step(study),
        convergence=_convergence(study, exact),  # steps [s] and errors, by method
        good=max(good, default=None),  # the largest of methods that converge, at the middle step
        bad=(min(bad), max(bad)) if bad else None,  # the smallest and the largest of the others
        steps=STEPS,
    )


def _errors(study: Study, method: str) -> Record:
    """Relative errors of the displacement of a method at STEPS, and of the turned scene."""
    errors = tuple(measured_error(study, LINE, method, step) for step in STEPS)
    return Record(
        method=method, errors=errors, turned=measured_error(study, TURNED, method, TURNED_STEP)
    )


def _convergence(study: Study, exact: float) -> Mapping[str, Mapping[str, Sequence[float]]]:
    """The relative error of the final displacement of some methods against the step."""
    by_method = {}
    for series in study.convergence:
        done = [run for run in series.measurements if run.status == "done"]
        if series.scene == LINE and series.method in COMPARED and done:
            ends = [run.errors["displacement"].end / exact for run in done]
            by_method[series.method] = {"steps": [run.step for run in done], "errors": ends}
    return by_method


def _beyond_the_step(study: Study) -> tuple[Record, ...]:
    """The errors of the two models beyond the step's, and what explains them [m]."""
    explained = list[Record]()
    for name in (FULL, REDUCED):
        for step in STEPS:
            if (run := measured(study, LINE, name, step)) is None:
                continue
            error = run.errors["displacement"].end - step_term(LINE, step)
            contact = contact_of(LINE, name, step)
            deflection, drift = deflection_term(LINE, contact), stiction_drift(LINE, contact)
            left = error - deflection - drift
            explained.append(
                Record(
                    method=name,
                    step=step,  # [s]
                    error=error,
                    deflection=deflection,
                    drift=drift,
                    unexplained=left,
                )
            )
    return tuple(explained)


def _converge(numbers: Record) -> Claims:
    if numbers.good is None or numbers.bad is None:
        return ()
    text = "errors of contacts that do not converge, and of those that do"
    return (clear(text, numbers.bad[0], numbers.good),)


ERRORS = Analysis("capsule_line/displacement", errors, claims=_converge)
