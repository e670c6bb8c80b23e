"""The final displacement: each method's error, its explanation, and the sawtooth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from plumbob.analytic.errors.sliding_motion.discontinuities import trapezoid_error
from plumbob.analytic.reference import Array
from plumbob.engines.study.extra_runs import ExtraRun, StudyPlan
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.claims import ALIKE, Claims, at_most, clear
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
    recordings,
    runs,
)

STEPS = (1e-3, 1e-4, 1e-5)
TURNED, TURNED_STEP = "capsule-line/heading-030", 1e-4
FULL, REDUCED = "mujoco/euler+coulomb", "mujoco/euler+reduced"
CONVERGENT = ("coulomb", "coulomb+noslip", "reduced", "feet", "side")  # theory covers these
COMPARED = ("mujoco/euler", FULL, "mujoco/rk4+coulomb", "pymunk/feet")
METHODS = (REDUCED, FULL, "pymunk/side", "pymunk/feet")  # of the sawtooth
COUNT = 4  # steps drawn at random, fifteen times as many in the full profile
COARSE, FINE = 2.5e-3, 6e-4  # [s], what they are drawn between
SEED = 20200101
PART = 0.2  # of the parabola's top: below it, other terms are as large


def requests(plan: StudyPlan) -> Sequence[ExtraRun]:
    """The check manoeuvre at steps drawn at random."""
    return runs((LINE,), METHODS, random_steps(plan.profile))


def random_steps(profile: str) -> tuple[float, ...]:
    """Steps [s] drawn at random, evenly in their logarithm; the same in every study."""
    count = COUNT * (15 if profile == "full" else 1)
    draw = np.random.default_rng(SEED).uniform(np.log(FINE), np.log(COARSE), count)
    return tuple(float(step) for step in np.exp(draw))


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


def sawtooth(study: Study) -> Record | None:
    """The errors at steps drawn at random against the parabola, and how near they are."""
    line = problem(LINE).motion
    phases = np.linspace(0.0, 1.0, 101)
    # The deflection term is the same multiple of dt^2 at every step.
    fine = line.t1 / 100
    raised = -deflection_term(LINE, contact_of(LINE, FULL, fine)) / (line.closed.braking * fine**2)
    parabola = _parabola(phases)
    every = [_places(study, name, raised if name == FULL else 0.0) for name in METHODS]
    methods = tuple(filter(None, every))
    return (
        Record(
            phases=phases,
            parabola=parabola,
            raised_parabola=parabola + raised,  # of the full model, by its contacts' deflection
            raised=8.0 * raised,  # by how much, over the parabola's top
            methods=methods,
            coarse=COARSE,
            fine=FINE,
            seed=SEED,
        )
        if methods
        else None
    )


def _parabola(phases: Array) -> Array:
    return 0.5 * phases * (1 - phases)


def _places(study: Study, method: str, raised: float) -> Record | None:
    """phi, and the error over -(mu w2 + f g) dt^2 without that of the corner at t1; `raised` by the
    deflection of contacts."""
    by_request = recordings(study, runs((LINE,), (method,), random_steps(study.profile)))
    if not by_request:
        return None
    line = problem(LINE).motion
    steps = np.array([request.step for request in by_request])
    ends = np.array([run.observables["displacement"][-1] for run in by_request.values()])
    at_t1 = trapezoid_error(line.closed.backward + line.closed.braking, line.t1 / steps)
    errors = (at_t1 - (ends - line.displacement) / steps**2) / line.closed.braking
    phases = line.t_star / steps % 1.0
    theory = _parabola(phases)
    used = theory > PART / 8
    bare, deflected = (np.abs((errors - part) / theory - 1)[used].max() for part in (0.0, raised))
    return Record(
        method=method,
        phases=phases,  # fraction of a step at which the body stops
        errors=errors,
        distance=bare,  # the largest from the parabola, relative
        deflected_distance=deflected,  # the same with the deflection of contacts added
    )


def _near(numbers: Record) -> Claims:
    return tuple(
        at_most(
            f"the distance of {places.method} from the parabola, relative,",
            places.deflected_distance,
            ALIKE,
        )
        for places in numbers.methods
    )


ERRORS = Analysis("capsule_line/displacement", errors, claims=_converge)
SAWTOOTH = Analysis("capsule_line/sawtooth", sawtooth, requests, _near)
