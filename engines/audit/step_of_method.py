"""The error of a method's steps on the motion of a user's model, and its largest step. The method
is an integrator of MuJoCo's, or another engine that builds the model's mechanism."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.abilities import BuildsMechanisms
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.built_mechanism import BuiltSteppers, built_runs
from plumbob.engines.audit.controls import MOST
from plumbob.engines.audit.reference import Certificate
from plumbob.engines.audit.stability import (
    PATIENCE,
    LargestSteps,
    Limit,
    largest_steps,
)
from plumbob.engines.audit.step_errors import (
    StepError,
    error_at_step,
    step_error_of_run,
    with_costs,
)
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.own_motion import PERIOD_ROUNDING, OwnModel, Script
from plumbob.engines.registry import engine_of, engines
from plumbob.engines.workers import Lost, Task, Workers
from plumbob.models.entry_points import captured

MUJOCO = "mujoco"  # the engine of the model files
# the only setting of methods that merely choose an integrator of MuJoCo
INTEGRATOR = "integrator"
DISCRETE = "discrete"  # an integrator of MuJoCo that audits do not try
HANGS = 60.0  # [s] time in addition to the run: an engine is loaded


def parts_of(script: Script, step: float) -> int:
    """Returns the number of steps [s] in a control period. Raises ParameterError unless it is a
    whole number."""
    parts = round(script.period / step) if step * MOST > script.period / 2.0 else MOST + 1
    what = f"a whole fraction of the control period of {script.period:g} s"
    if parts > MOST:
        raise ParameterError("step", step, f"{what}, at most {MOST} steps of it")
    if not parts or abs(parts * step / script.period - 1.0) > PERIOD_ROUNDING:
        near = script.period / max(1, parts)
        raise ParameterError("step", step, f"{what}, such as {near:.9g}")
    return parts


def runs_of(method: Method, able: Sequence[str]) -> str:
    """Returns the integrator of MuJoCo's that a method is, one of those that are `able` to step a
    model, or the name of the method if its engine builds mechanisms. Raises ParameterError for any
    other method."""
    if method.engine == MUJOCO:
        return integrator_of(method, able)
    builds = engine_of(method).ability(BuildsMechanisms)
    if builds is None or builds.method != method.name:
        what = f"of MuJoCo, as mujoco/rk4, or one of {', '.join(_building_methods())}"
        raise ParameterError("method", method.name, f"{what}, where a model file is run")
    return method.name


def integrator_of(method: Method, able: Sequence[str]) -> str:
    """Returns the integrator of MuJoCo's that a method is, one of those that are `able` to step a
    model. Raises ParameterError for any other method."""
    if method.engine != MUJOCO:
        raise ParameterError(
            "method", method.name, "of MuJoCo, as mujoco/rk4, for a model file"
        )
    others = ", ".join(name for name in method.settings if name != INTEGRATOR)
    integrator = str(method.settings[INTEGRATOR]).lower()
    if others:
        what = f"an integrator alone, without {others}: contacts and controls are the file's"
        raise ParameterError("method", method.name, what)
    if integrator not in able:
        what = f"one by which MuJoCo steps this model: {', '.join(able)}"
        raise ParameterError("method", method.name, what)
    return integrator


def _building_methods() -> list[str]:
    """Returns the methods of engines that build mechanisms."""
    every = (engine.ability(BuildsMechanisms) for engine in engines().values())
    return [builds.method for builds in every if builds is not None]


def method_error(
    method: Method,
    model: OwnModel,
    script: Script,
    reference: Certificate,
    step: float,
    seconds: float,
) -> StepError:
    """Returns the error of a method at a step [s]; if the method is MuJoCo's, with its cost. A run
    in another engine has a process of its own, which the engine may crash. Raises ParameterError,
    also if the run would take more than `seconds` of processor time, and Unsupported if the engine
    cannot express a part of the model."""
    parts = parts_of(script, step)
    integrator = runs_of(method, (*model.steppable, DISCRETE))
    if integrator != method.name:
        _check_budget(model, script, integrator, parts, seconds)
        return with_costs(
            model,
            script,
            reference,
            [error_at_step(model, script, reference, integrator, parts)],
        )[0]
    arguments = (method, model, script, reference, parts, seconds)
    error: StepError = in_own_process(_built_error, arguments, 2.0 * seconds)
    return error


def in_own_process(work: Callable[..., Any], arguments: tuple[Any, ...], seconds: float) -> Any:
    """Returns the result of `work` with another engine, in a process of its own, which the engine
    may crash; its output is suppressed. Raises Unsupported if the work does, if the process ends,
    or if it takes far more than `seconds` of processor time."""
    with Workers(1) as workers:
        ((_, answer),) = workers.results(
            [Task("", _without_output, (work, arguments), HANGS + seconds)]
        )
    if isinstance(answer, Lost):
        raise Unsupported(answer.why)
    return answer


def _without_output(work: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """Returns the result of `work`, with its output suppressed."""
    with captured():
        return work(*arguments)


def builder_of(method: Method) -> BuildsMechanisms:
    """Returns the builder of mechanisms of a method of an engine other than MuJoCo."""
    builds = engine_of(method).ability(BuildsMechanisms)
    assert builds is not None
    return builds


def _check_budget(
    model: OwnModel, script: Script, integrator: str, parts: int, seconds: float
) -> None:
    """Raises ParameterError if a run would take more than `seconds` of processor time, judged by
    its first control period."""
    first_period = model.stepped(
        replace(script, controls=script.controls[:1]), integrator, parts
    )
    needed = first_period.seconds * len(script.controls)
    if needed > seconds:
        raise ParameterError("budget", seconds, f"{needed:.2g} or more: the run takes as long")


def _built_error(
    method: Method,
    model: OwnModel,
    script: Script,
    reference: Certificate,
    parts: int,
    seconds: float,
) -> StepError:
    """Returns the error of another engine. Raises Unsupported."""
    built = built_runs(builder_of(method), model, script, parts, seconds)
    return step_error_of_run(built.run(script), model, reference, method.name, parts)


def method_steps(
    methods: Sequence[Method],
    model: OwnModel,
    script: Script,
    states: Array,
    allowance: Allowance,
) -> LargestSteps:
    """Returns the largest steps of methods, in their order, along a motion whose `states` at the
    ends of the control periods are known, and remedies for the first method. Without methods, the
    steps are those of all of MuJoCo's integrators. Each engine other than MuJoCo has a process of
    its own, and again as much time. Raises ParameterError."""
    if not methods:
        return largest_steps(model, script, states, allowance)
    method_of = {runs_of(method, model.steppable): method for method in methods}
    integrators = tuple(name for name in method_of if name in model.steppable)
    groups = list[LargestSteps]()
    if integrators:
        limited_model = model.with_integrators(integrators)
        groups.append(largest_steps(limited_model, script, states, allowance))
    for name in (name for name in method_of if name not in integrators):
        seconds = allowance.seconds
        arguments = (method_of[name], model, script, states, seconds)
        try:
            groups.append(in_own_process(_built_steps, arguments, PATIENCE * seconds))
        except Unsupported as why:
            unknown = Limit(name, None, why=str(why))
            groups.append(LargestSteps((unknown,), (), model.step))
    every_limit = chain.from_iterable(group.limits for group in groups)
    limits = {limit.integrator: limit for limit in every_limit}
    (first,) = (group for group in groups if group.own.integrator == next(iter(method_of)))
    return replace(first, limits=tuple(limits[name] for name in method_of))


def _built_steps(
    method: Method, model: OwnModel, script: Script, states: Array, seconds: float
) -> LargestSteps:
    """Returns the largest step of another engine. Raises Unsupported."""
    steppers = BuiltSteppers(builder_of(method), model)
    return largest_steps(model, script, states, Allowance(seconds), steppers)
