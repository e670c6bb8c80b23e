"""The final displacement: the error of each method, beside theory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.analytic.errors.sliding_motion.sliding_errors import step_error
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clearly_larger
from plumbob.reports.analyses.measurements import (
    CHECK_LINE,
    covers,
    measured_error,
    method_names,
    problem,
)

DISPLACEMENT_STEPS = (1e-3, 1e-4, 1e-5)  # [s]
TURNED_SCENE, TURNED_STEP = "capsule-line/heading-030", 1e-4  # [s]
# contact settings whose errors theory predicts
CONVERGENT_CONTACTS = ("coulomb", "coulomb+noslip", "reduced", "feet", "side")
COMPARED_METHODS = ("mujoco/euler", "mujoco/euler+coulomb", "mujoco/rk4+coulomb", "pymunk/feet")


def step_term(scene: str, step: float) -> float:
    """Returns the step's error of the displacement, -phi (1 - phi)(mu w2 + f g) dt^2/2 [m], where
    phi is the fractional part of t_star/dt. If t1 is no multiple of the step, the corner of the
    velocity at t1 contributes too."""
    return float(step_error(problem(scene).motion, step))


def displacement_errors(study: Study) -> Record | None:
    """Returns the relative errors of the displacement by method and step, and the predicted errors;
    None if the study lacks the scene."""
    if not covers(study, CHECK_LINE):
        return None
    exact = problem(CHECK_LINE).motion.displacement
    by_method = [_errors(study, name) for name in method_names(study)]
    methods = [row for row in by_method if any(error is not None for error in row.errors)]
    good = [
        abs(row.errors[1])
        for row in methods
        if row.method.endswith(CONVERGENT_CONTACTS) and row.errors[1] is not None
    ]
    return Record(
        exact=exact,  # [m]
        # relative error at DISPLACEMENT_STEPS
        predicted=[step_term(CHECK_LINE, step) / exact for step in DISPLACEMENT_STEPS],
        predicted_turned=step_term(CHECK_LINE, TURNED_STEP) / exact,
        methods=methods,
        convergence=_convergence(study, exact),  # steps [s] and relative errors, by method
        # largest error at the middle step of methods whose contacts converge
        good=max(good, default=None),
        bad=_without_convergence(study, exact),
        steps=DISPLACEMENT_STEPS,
    )


def _without_convergence(study: Study, exact: float) -> Record | None:
    """Returns the range of the relative errors of the final displacement over all runs whose
    contacts do not converge, the range of their steps [s], and the range of the errors in the
    turned scene; None if there is no such run. `exact` is the exact displacement [m]."""
    others = [n for n in method_names(study) if not n.endswith(CONVERGENT_CONTACTS)]
    runs = [
        run
        for series in study.convergence
        if series.scene == CHECK_LINE and series.method in others
        for run in _finished_runs(series)
    ]
    if not runs:
        return None
    errors = [abs(run.errors["displacement"].end / exact) for run in runs]
    steps = [run.step for run in runs]
    turned = [measured_error(study, TURNED_SCENE, name, TURNED_STEP) for name in others]
    known = [abs(error) for error in turned if error is not None]
    return Record(
        errors=(min(errors), max(errors)),
        steps=(min(steps), max(steps)),
        turned=(min(known), max(known)) if known else None,
    )


def _finished_runs(series: ConvergenceStudy) -> list[Measurement]:
    """Returns the runs of a convergence study that reached their end."""
    return [run for run in series.measurements if run.status == "done"]


def _errors(study: Study, method: str) -> Record:
    """Returns a method's relative errors of the displacement at DISPLACEMENT_STEPS, and its error
    in the turned scene."""
    return Record(
        method=method,
        errors=tuple(
            measured_error(study, CHECK_LINE, method, step) for step in DISPLACEMENT_STEPS
        ),
        turned=measured_error(study, TURNED_SCENE, method, TURNED_STEP),
    )


def _convergence(study: Study, exact: float) -> Mapping[str, Mapping[str, Sequence[float]]]:
    """Returns the steps [s] and the relative errors of the final displacement, for each of
    COMPARED_METHODS that ran."""
    by_method = {}
    for series in study.convergence:
        done = _finished_runs(series)
        if series.scene == CHECK_LINE and series.method in COMPARED_METHODS and done:
            ends = [run.errors["displacement"].end / exact for run in done]
            by_method[series.method] = {"steps": [run.step for run in done], "errors": ends}
    return by_method


def _converge(numbers: Record) -> Claims:
    """Returns the check that the smallest error of the contacts that do not converge is clearly
    larger than the error of the contacts that converge."""
    if numbers.good is None or numbers.bad is None:
        return ()
    text = "errors of contacts that do not converge, and of those that do"
    return (clearly_larger(text, numbers.bad.errors[0], numbers.good),)


DISPLACEMENT_ERRORS = Analysis(
    "capsule_line/displacement", displacement_errors, claims=_converge
)
