"""The certified answer of a scene, compared with its exact answer. The certified answer is the
continuous motion of the scene's model in MuJoCo, integrated as an audit integrates a user's
model."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.left_open import roundings
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Signals
from plumbob.engines.abilities import CompilesScenes
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import MOST, PERIOD
from plumbob.engines.audit.reference import (
    Certificate,
    certified,
    largest_distances,
    running_maximum,
)
from plumbob.engines.audit.user_models import quiet
from plumbob.engines.method import Method, meant
from plumbob.engines.own_motion import NotCertifiable, OwnModel, Script
from plumbob.engines.registry import engine_of, find_engine
from plumbob.engines.registry import method as find_method
from plumbob.engines.sampling import step_count
from plumbob.engines.study.measurement import REFERENCE_STEP
from plumbob.engines.trajectory import lost
from plumbob.models.scene import Case

# Methods of MuJoCo's whose model is certified for a run in another engine: the first that is meant
# for the scene. Its contacts tend to rigid contacts.
MODELS = ("mujoco/euler+coulomb", "mujoco/euler+stiff", "mujoco/euler")
SAME_TIME = 1e-9  # largest relative rounding of times that a run adds up or multiplies


@dataclass(frozen=True)
class SceneReference:
    """The certified answer of a scene at the `times` [s], shape (n,), up to which it is
    certified."""

    method: Method  # the method of MuJoCo's whose model is certified
    step: float  # [s] step to which the model's contacts are adapted
    # Whether contacts or loops of the model yield; those of the exact answer are rigid
    yields: bool
    periods: int  # number of equal parts of the scene's duration, whose ends are the times
    times: Array
    observables: Signals  # shape (n,) each, without those that a state does not determine
    uncertainty: Signals  # largest uncertainty so far of each observable, shape (n,)
    why: str  # why it is certified no further; empty if it reaches the end


@dataclass(frozen=True)
class TwoAnswers:
    """The exact and the certified answer of one observable, in its unit. Each number is the largest
    up to the time to which the motion is certified."""

    error: float  # error of a run against the certified answer; NaN if the run was lost
    error_from_exact: float  # error of the same run at the same times, against the exact answer
    uncertainty: float  # uncertainty of the certified answer
    distance: float  # distance between the two answers
    rounding: float  # bound on the effect of double precision on either answer
    model_error: float  # declared bound on the errors of the model in MuJoCo

    @property
    def within(self) -> bool:
        """Whether the two answers differ by no more than they state."""
        return self.distance <= self.uncertainty + self.rounding + self.model_error


def two_answers(
    case: Case, method: Method, step: float, reference: SceneReference
) -> Mapping[str, TwoAnswers]:
    """Returns {observable: its two answers} of a case, with the errors of a run of `method` at
    `step` [s], or relative tolerance. Raises Unsupported."""
    times = reference.times
    exact = case.reference.observe(times)
    rounded = case.reference.uncertainty(times)
    declared = engine_of(reference.method).model_error(case, reference.method, reference.step)
    names = [o.name for o in case.system.observables if o.name in reference.observables]
    run = _run_observables(case, method, step, reference)
    answers = {}
    for name in names:
        certain = reference.observables[name]
        ran = run.get(name, np.full(len(times), np.nan))
        answers[name] = TwoAnswers(
            error=_largest_magnitude(ran - certain),
            error_from_exact=_largest_magnitude(ran - exact[name]),
            uncertainty=float(reference.uncertainty[name][-1]),
            distance=float(np.abs(certain - exact[name]).max()),
            rounding=float(rounded[name].max()) * roundings(reference.periods),
            model_error=sum(declared.get(name, {}).values()),
        )
    return answers


def _largest_magnitude(error: Array) -> float:
    """Returns the largest magnitude of errors, shape (n,), after the start and without NaN; NaN if
    none is left."""
    known = np.abs(error[1:][np.isfinite(error[1:])])
    return float(known.max()) if known.size else math.nan


def _run_observables(
    case: Case, method: Method, step: float, reference: SceneReference
) -> Signals:
    """Returns the observables of a run at the times of a reference, shape (n,) each; NaN at times
    that the run does not have, and empty if the run is lost. Raises Unsupported."""
    sampled = case.lasting(case.scene.duration, reference.periods)
    run = engine_of(method).prepare(sampled, method, step).run()
    if lost(run):
        return {}
    times = reference.times
    nearest = np.searchsorted(run.times, times * (1.0 - SAME_TIME)).clip(max=len(run.times) - 1)
    reached = np.isclose(run.times[nearest], times, SAME_TIME, 0.0)
    return {
        name: np.where(reached, values[nearest], np.nan)
        for name, values in run.observables.items()
    }


def scene_reference(case: Case, method: Method, step: float, seconds: float) -> SceneReference:
    """Returns the certified answer of the model that MuJoCo steps for a case with `method` at
    `step` [s]. If the method is another engine's, the model is that of the first of MODELS. It
    takes `seconds` of processor time at most. Raises Unsupported, ParameterError and
    NotCertifiable."""
    chosen, step = _model_method(case, method, step)
    compiles = find_engine("mujoco").ability(CompilesScenes)
    assert compiles is not None
    with quiet():
        model, observables = compiles.model(case, chosen, step)
        script = Script(model.state, *_periods(case, model, step))
        reference = certified(model, script, Allowance(seconds))
        if not reference.known:
            raise NotCertifiable(reference.why)
        values = observables(reference.states)
        uncertainty = _uncertainty(model, reference, observables, values)
    mechanism = model.mechanism()
    return SceneReference(
        method=chosen,
        step=step,
        yields=bool(mechanism.loops or mechanism.touching),
        periods=len(script.controls),
        times=script.times[: reference.known + 1],
        observables=values,
        uncertainty=uncertainty,
        why=reference.why,
    )


def _model_method(case: Case, method: Method, step: float) -> tuple[Method, float]:
    """Returns the method of MuJoCo's whose model represents a method, and its step [s]. A method
    with a tolerance in place of a step gets a step of about REFERENCE_STEP."""
    duration = case.scene.duration
    if method.control != "step":
        step = duration / max(1, round(duration / REFERENCE_STEP))
    if method.engine == "mujoco":
        return method, step
    return model_method(case), step


def model_method(case: Case) -> Method:
    """Returns the method of MuJoCo's whose model stands for a case: the first of MODELS that is
    meant for its scene."""
    every = (find_method(name) for name in MODELS)
    return next((m for m in every if meant(m, case.scene)), find_method(MODELS[-1]))


def _periods(case: Case, model: OwnModel, step: float) -> tuple[float, Array]:
    """Returns the length [s] of equal parts of a case, and the controls that are held over them,
    shape (periods, actuators). A part is a whole number of steps [s], and PERIOD at most if the
    steps allow it. Raises ParameterError for more than MOST periods."""
    steps = step_count(case.scene.duration, step)
    longest = max(1, round(PERIOD / step))
    parts = next(parts for parts in range(longest, 0, -1) if steps % parts == 0)
    count = steps // parts
    if count > MOST:
        what = f"one of which {MOST} periods of {PERIOD:g} s or less cover the motion"
        raise ParameterError("step", step, what)
    return parts * step, np.tile(model.rest, (count, 1))


def _uncertainty(
    model: OwnModel,
    reference: Certificate,
    observables: Callable[[Array], Signals],
    values: Signals,
) -> Signals:
    """Returns the uncertainty of observables at the ends of the periods, shape (n,) each: their
    largest distance so far from the other computation, times the factor by which the uncertainty of
    the reference exceeds the displacements between the two computations."""
    states = reference.confirmed_by.states[: reference.known + 1]
    displacements = largest_distances(reference.corners[: len(states)], model.corners(states))
    factors = np.ones(len(states))
    stated = reference.uncertainty[: len(states)]
    np.divide(stated, displacements, out=factors, where=displacements > 0.0)
    return {
        name: np.maximum(factors, 1.0)
        * running_maximum(np.abs(values[name] - confirming)[:, None])
        for name, confirming in observables(states).items()
    }
