"""Checks of an engine's adapter, by running it: that the adapter builds its scenes, repeats its
results, samples at its steps, writes nothing, reports a failed run, counts its steps, and converges
at its declared order."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import chdir, suppress
from dataclasses import dataclass
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Literal

import numpy as np

from plumbob.engines.method import Engine, Method, Simulation, Unsupported, meant
from plumbob.engines.registry import unguarded
from plumbob.engines.sampling import step_count
from plumbob.engines.study.convergence import chosen_step_sizes, convergence_study
from plumbob.engines.study.cost import false_cost
from plumbob.engines.study.measurement import not_asked_for
from plumbob.engines.study.runner import most_steps
from plumbob.engines.trajectory import Trajectory, not_a_trajectory
from plumbob.models.entry_points import captured
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Case, Scene
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.verdict import judge_method

# Largest delay of the first sample, in steps. The delay of a method that converges tends to zero.
LARGEST_DELAY = 0.25
# Largest difference of two runs at the same time, relative to one step's motion.
SAME_TIME_ERROR = 1e-3
ORDER_MARGIN = 0.3  # largest amount by which an observed order may be below the declared order
# Scenes that must show an order, and scenes that are tried for it.
ORDER_SCENES, TRIED_SCENES = 3, 9
# most steps of a run whose samples are checked: one sample every three steps
MAX_CHECKED_STEPS = 1201
COARSE_STEPS = 8  # steps in a run that should diverge

CheckStatus = Literal["pass", "fail", "not checked"]


class NotChecked(Exception):
    """The reason why something cannot be checked for a method."""


@dataclass(frozen=True)
class CheckOutcome:
    """The outcome of one check for all methods of an engine."""

    name: str
    status: CheckStatus
    detail: str  # the result, or the method that fails and the reason


@dataclass(frozen=True)
class CheckedMethod:
    """A method under check, with the scenes that it is meant for, fewest steps first."""

    engine: Engine
    method: Method
    scenes: tuple[Scene, ...]

    def simulation(self, case: Case, step: float) -> Simulation:
        """Returns the case built by the engine itself; the engine's errors are raised."""
        return self.engine.prepare(case, self.method, step)

    def checked_step(self, scene: Scene) -> float:
        """Returns the step [s] at which a scene is checked: the middle one of the quick profile's
        step sizes. For a solver with a tolerance it returns the tightest tolerance."""
        sizes = chosen_step_sizes(scene, self.method, most_steps(scene, "quick"))
        return sizes[len(sizes) // 2] if self.method.control == "step" else sizes[-1]

    @property
    def short_case(self) -> tuple[Case, float]:
        """Returns the first case that the engine builds, cut to at most MAX_CHECKED_STEPS steps,
        and its step; raises NotChecked if the engine builds none."""
        for scene in self.scenes:
            case = case_of(scene)
            step = self.checked_step(scene)
            if self.method.control == "step":
                steps = min(MAX_CHECKED_STEPS, round(scene.duration / step))
                case = case.lasting(steps * step)
            with suppress(Unsupported):
                self.simulation(case, step)
                return case, step
        raise NotChecked("it builds no scene")

    def run(self, case: Case, step: float) -> Trajectory:
        """Runs a case and returns the trajectory; raises AssertionError if the samples, the end or
        the count of steps are not as asked for."""
        run = self.simulation(case, step).run()
        fault = not_a_trajectory(run) or not_asked_for(case, self.method, step, run)
        _require(not fault, f"a run of {case.scene.name}: {fault}")
        return run


# A check: returns its result in words; raises AssertionError and NotChecked.
Check = Callable[[CheckedMethod], str]


def check_engine(methods: Sequence[Method], scenes: Sequence[Scene]) -> Iterator[CheckOutcome]:
    """Yields the outcome of each check over an engine's methods. Each method is checked on those of
    `scenes` that it is meant for."""
    checked_methods = [
        CheckedMethod(unguarded(method.engine), method, _sorted_scenes(method, scenes))
        for method in methods
    ]
    for name, check in CHECKS.items():
        yield _check_outcome(name, check, checked_methods)


def _sorted_scenes(method: Method, scenes: Sequence[Scene]) -> tuple[Scene, ...]:
    """Returns the scenes that a method is meant for: hard ones last, otherwise fewest steps
    first."""

    def sort_key(scene: Scene) -> tuple[bool, float, str]:
        steps = scene.duration / min(scene.steps) * system_of(scene).weight
        return bool(scene.hard), steps, scene.name

    chosen = [scene for scene in scenes if meant(method, scene)]
    return tuple(sorted(chosen, key=sort_key))


def _check_outcome(name: str, check: Check, methods: Sequence[CheckedMethod]) -> CheckOutcome:
    """Returns a check's outcome over all methods: the first failure, else the first pass."""
    outcomes: dict[CheckStatus, list[str]] = {"fail": [], "pass": [], "not checked": []}
    for checked in methods:
        status, detail = _method_outcome(check, checked)
        outcomes[status].append(f"{checked.method.name}: {detail}")
    for status, details in outcomes.items():
        if details:
            more = f" (and {len(details) - 1} more)" if len(details) > 1 else ""
            return CheckOutcome(name, status, " ".join((details[0] + more).split()))
    return CheckOutcome(name, "not checked", "no method")


def _method_outcome(check: Check, checked: CheckedMethod) -> tuple[CheckStatus, str]:
    """Returns a check's outcome for one method, with its detail."""
    try:
        # Output and files of the engine are caught: `check_output` checks for them.
        with TemporaryDirectory() as folder, chdir(folder), captured():
            return "pass", check(checked)
    except NotChecked as reason:
        return "not checked", str(reason)
    except AssertionError as reason:
        return "fail", str(reason)
    except Exception as error:
        return "fail", f"{type(error).__name__}: {error}"


def _require(holds: object, why: str) -> None:
    """Raises AssertionError with a reason if a condition is false, under `python -O` too."""
    if not holds:
        raise AssertionError(why)


def check_builds(checked: CheckedMethod) -> str:
    """Checks that every scene that the method is meant for is built, or declared as unsupported."""
    built = 0
    for scene in checked.scenes:
        try:
            simulation = checked.simulation(case_of(scene), checked.checked_step(scene))
        except Unsupported as reason:
            verdict = expected(scene.name, checked.method.name).verdict
            message = f"it is meant for {scene.name}, and refuses it: {reason}"
            _require(verdict == "unsupported", message)
            continue
        for part in ("run", "stepped"):
            is_method = callable(getattr(simulation, part, None))
            _require(is_method, f"a simulation has no {part}()")
        built += 1
    if not built:
        raise NotChecked("it is meant for none of the scenes")
    return f"{built} scenes"


def check_repeats(checked: CheckedMethod) -> str:
    """Checks that two runs of one simulation, and a run of a second one, agree to the last bit."""
    case, step = checked.short_case
    simulation = checked.simulation(case, step)
    first = simulation.run()
    second = simulation.run()
    third = checked.simulation(case, step).run()
    for number, run in ((2, second), (3, third)):
        for name, values in first.observables.items():
            same = np.array_equal(values, run.observables[name])
            pair = f"run {number} of {case.scene.name} and run 1"
            _require(same, f"{name} differs between {pair}")
    return f"3 runs of {case.scene.name}, the same bits"


def check_samples(checked: CheckedMethod) -> str:
    """Checks that samples stand at times of whole steps, from the start to the end, and that each
    sample holds the state at its time, not the state one step earlier or later."""
    case, step = checked.short_case
    run = checked.run(case, step)
    solver = checked.method.control == "tolerance"
    exact = case.reference.observe(run.times)
    uncertainty = case.reference.uncertainty(run.times[:1])
    for name in _state_names(case, run):
        error = run.observables[name] - exact[name]
        size = np.abs(exact[name]).max() or 1.0
        allowed = 10.0 * uncertainty[name][0] + 1e-9 * size
        wrong_start = f"{name} starts {error[0]:.3g} from the start of {case.scene.name}"
        _require(abs(error[0]) <= allowed, wrong_start)
        if solver:
            largest_change = np.abs(np.diff(exact[name])).max()
            on_time = np.abs(error).max() <= LARGEST_DELAY * largest_change
            _require(on_time, f"{name} is late by more than {LARGEST_DELAY:g} of a sample")
    if not solver:
        _check_first_step(case, checked.run(case.lasting(step), step), step)
        for sample in {1, len(run.times) // 2}:
            shorter_case = case.lasting(float(run.times[sample]))
            _check_shorter_run(run, checked.run(shorter_case, step), sample)
    return f"{len(run.times)} samples of {case.scene.name}"


def _check_first_step(case: Case, run: Trajectory, step: float) -> None:
    """Checks that an observable that changes evenly at the start changes by the exact amount in the
    first step, to LARGEST_DELAY of it. Its change is even if the change over two steps is twice the
    change over one, within 10 %. A method's own error is smaller by an order of the step. A sample
    that is one step late is wrong by the whole change."""
    times = np.array([0.0, step, 2.0 * step])
    exact = case.reference.observe(times)
    uncertainty = case.reference.uncertainty(times)
    for name in _state_names(case, run):
        first_change, both_changes = exact[name][1:] - exact[name][0]
        known = abs(first_change) > 1e3 * uncertainty[name].max()
        if known and abs(both_changes / first_change - 2.0) < 0.1:
            error = float(run.observables[name][-1] - exact[name][1])
            steps_ahead = error / float(first_change)
            message = f"after one step {name} is {steps_ahead:+.2f} steps ahead of time"
            _require(abs(steps_ahead) <= LARGEST_DELAY, message)


def _check_shorter_run(run: Trajectory, shorter: Trajectory, sample: int) -> None:
    """Checks that a shorter run ends with the values that a longer run holds at that sample."""
    for name, values in run.observables.items():
        nearby = values[max(sample - 1, 0) : sample + 2]
        step_motion = np.abs(np.diff(nearby)).max(initial=0.0)
        size = np.abs(values).max(initial=0.0)
        difference = abs(values[sample] - shorter.observables[name][-1])
        same = difference <= SAME_TIME_ERROR * step_motion + 1e-9 * size
        steps = shorter.steps
        message = f"{name} at step {steps} differs from the end of a run of {steps} steps"
        _require(same, message)


def _state_names(case: Case, run: Trajectory) -> list[str]:
    """Names of the observables that a run gives and that are coordinates or rates. Forces are left
    out: steps do not change them."""
    states = [o.name for o in case.system.observables if not o.force]
    return [name for name in states if name in run.observables]


def check_output(checked: CheckedMethod) -> str:
    """Checks that building and running leaves no file and prints nothing."""
    case, step = checked.short_case
    with captured() as output:
        simulation = checked.simulation(case, step)
        simulation.run()
        simulation.stepped(0.5)
    files = sorted(os.listdir())
    _require(not files, f"it leaves files: {', '.join(files[:3])}")
    _require(not output[0].strip(), f"it prints: {output[0].strip()[:80]}")
    return "no output, no file"


def check_divergence(checked: CheckedMethod) -> str:
    """Checks that a run at far too large steps ends with finite samples, or with the time at which
    the run diverged, and that it raises nothing."""
    if checked.method.control == "tolerance":
        raise NotChecked("it chooses its steps")
    diverged = 0
    # The scene with the fewest steps of each system.
    scenes = {scene.system: scene for scene in reversed(checked.scenes)}
    for scene in scenes.values():
        step = scene.duration / COARSE_STEPS
        with suppress(Unsupported):
            run = checked.simulation(case_of(scene), step).run()
            fault = not_a_trajectory(run)
            _require(not fault, f"{scene.name} at a step of {step:g} s: {fault}")
            diverged += run.diverged_at is not None
    return (
        f"{diverged} of {len(scenes)} systems diverged in runs of {COARSE_STEPS} steps, and "
        "reported it"
    )


def check_cost(checked: CheckedMethod) -> str:
    """Checks that a run counts its steps, that `stepped` takes the fraction of the steps asked for,
    and that timed steps cost what steps of a run cost."""
    case, step = checked.short_case
    run = checked.run(case, step)
    simulation = checked.simulation(case, step)
    full = simulation.stepped(1.0)
    half = simulation.stepped(0.5)
    _require(simulation.compile_seconds >= 0.0, "compile_seconds is negative")
    for name, timed in (("a run", run), ("stepped(1)", full), ("stepped(0.5)", half)):
        _require(timed.steps > 0, f"{name} counts no steps")
        _require(timed.seconds > 0.0, f"{name} takes no time")
    if checked.method.control == "step":
        count = step_count(case.scene.duration, step)
        for fraction, timed in ((1.0, full), (0.5, half)):
            difference = abs(timed.steps - fraction * count)
            message = f"stepped({fraction:g}) counts {timed.steps} steps of {count}"
            _require(difference <= 2.0 * (1.0 - fraction), message)
    (scene,) = (scene for scene in checked.scenes if scene.name == case.scene.name)
    fault = false_cost(case_of(scene), checked.method, step)
    _require(not fault, f"{case.scene.name}: {fault}")
    return f"{run.steps} steps of {case.scene.name}"


def check_order(checked: CheckedMethod) -> str:
    """Checks, on three scenes, that the error falls at the declared order or at the order that
    theory predicts for the scene, and that the verdict shows no fault."""
    method = checked.method
    if method.order is None:
        raise NotChecked("it chooses its steps: no order")
    slopes: dict[str, float] = {}
    for scene in _scenes_without_limit(checked)[:TRIED_SCENES]:
        study = convergence_study(scene, method, most_steps(scene, "quick"))
        case = case_of(scene)
        quantities = case.system.quantities(case)
        judgement = judge_method(study, case.system, method, quantities).whole
        accepted = judgement.verdict in ("predicted", "converges", "pre-asymptotic")
        _require(accepted, f"{scene.name}: {judgement.verdict}, {judgement.reason}")
        if study.order is None or judgement.verdict == "pre-asymptotic":
            continue
        least = float(method.order)
        if study.predicted_order:
            least = min(least, study.predicted_order.slope)
        slope = study.order.slope
        message = f"{scene.name}: order {slope:.2f}, declared {method.order}"
        _require(slope >= least - ORDER_MARGIN, message)
        slopes[scene.name] = slope
        if len(slopes) == ORDER_SCENES:
            break
    if not slopes:
        raise NotChecked("no scene shows an order")
    return ", ".join(f"{slope:.2f} on {scene}" for scene, slope in slopes.items())


def _scenes_without_limit(checked: CheckedMethod) -> list[Scene]:
    """Returns the scenes on which the method's verdict should be `predicted`."""
    name = checked.method.name
    return [
        scene for scene in checked.scenes if expected(scene.name, name).verdict == "predicted"
    ]


CHECKS: Mapping[str, Check] = MappingProxyType(
    {
        "builds": check_builds,
        "repeats itself": check_repeats,
        "samples at its steps": check_samples,
        "writes nothing": check_output,
        "reports divergence": check_divergence,
        "counts its cost": check_cost,
        "shows its order": check_order,
    }
)
