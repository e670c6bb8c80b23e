"""The final displacement: the error of each method, beside theory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from plumbob.analytic.errors.sliding_motion.sliding_errors import step_error
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import Claims, clear
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
    good = list[float]()  # errors at the middle step of methods whose contacts converge
    bad = list[float]()  # errors at the middle step of the others
    for row in methods:
        error = row.errors[1]
        if error is not None:
            (good if row.method.endswith(CONVERGENT_CONTACTS) else bad).append(abs(error))
    return Record(
        exact=exact,  # [m]
        # relative error at DISPLACEMENT_STEPS
        predicted=[step_term(CHECK_LINE, step) / exact for step in DISPLACEMENT_STEPS],
        predicted_turned=step_term(CHECK_LINE, TURNED_STEP) / exact,
        methods=methods,
        convergence=_convergence(study, exact),  # steps [s] and relative errors, by method
        # largest error at the middle step of methods whose contacts converge
        good=max(good, default=None),
        # smallest and largest error of the other methods at the middle step
        bad=(min(bad), max(bad)) if bad else None,
        steps=DISPLACEMENT_STEPS,
    )


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
        done = [run for run in series.measurements if run.status == "done"]
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
    return (clear(text, numbers.bad[0], numbers.good),)


DISPLACEMENT_ERRORS = Analysis(
    "capsule_line/displacement", displacement_errors, claims=_converge
)
