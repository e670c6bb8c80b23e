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
from plumbob.reports.judge.verdict import judged

# Largest delay of the first sample, in steps. The delay of a method that converges tends to zero.
LATE = 0.25
SAME = 1e-3  # largest difference of two runs at the same time, relative to one step's motion
BELOW = 0.3  # largest amount by which an observed order may be below the declared order
ORDERS, TRIED = 3, 9  # scenes that must show an order, and scenes that are tried for it
STEPS = 1201  # most steps of a run whose samples are checked: one sample every three steps
COARSE = 8  # steps in a run that should diverge

Status = Literal["pass", "fail", "not checked"]


class NotChecked(Exception):
    """The reason why something cannot be checked for a method."""


@dataclass(frozen=True)
class Checked:
    """The outcome of one check for all methods of an engine."""

    name: str
    status: Status
    detail: str  # the result, or the method that fails and the reason


@dataclass(frozen=True)
class Subject:
    """A method under check, with the scenes that it is meant for, fewest steps first."""

    engine: Engine
    method: Method
    scenes: tuple[Scene, ...]

    def prepared(self, case: Case, step: float) -> Simulation:
        """Returns the case built by the engine itself; the engine's errors are raised."""
        return self.engine.prepare(case, self.method, step)

    def step(self, scene: Scene) -> float:
        """Returns the step [s] at which a scene is checked: the middle one of the quick profile's
        step sizes. For a solver with a tolerance it returns the tightest tolerance."""
        sizes = chosen_step_sizes(scene, self.method, most_steps(scene, "quick"))
        return sizes[len(sizes) // 2] if self.method.control == "step" else sizes[-1]

    @property
    def short(self) -> tuple[Case, float]:
        """Returns the first case that the engine builds, cut to at most STEPS steps, and its step;
        raises NotChecked if the engine builds none."""
        for scene in self.scenes:
            case = case_of(scene)
            step = self.step(scene)
            if self.method.control == "step":
                case = case.lasting(min(STEPS, round(scene.duration / step)) * step)
            with suppress(Unsupported):
                self.prepared(case, step)
                return case, step
        raise NotChecked("it builds no scene")

    def run(self, case: Case, step: float) -> Trajectory:
        """Runs a case and returns the trajectory; raises AssertionError if the samples, the end or
        the count of steps are not as asked for."""
        run = self.prepared(case, step).run()
        why = not_a_trajectory(run) or not_asked_for(case, self.method, step, run)
        _hold(not why, f"a run of {case.scene.name}: {why}")
        return run


# A check: returns its result in words; raises AssertionError and NotChecked.
Look = Callable[[Subject], str]


def check_engine(methods: Sequence[Method], scenes: Sequence[Scene]) -> Iterator[Checked]:
    """Yields the outcome of each check over an engine's methods. Each method is checked on those of
    `scenes` that it is meant for."""
    subjects = [
        Subject(unguarded(method.engine), method, _ordered(method, scenes))
        for method in methods
    ]
    for name, look in CHECKS.items():
        yield _outcome(name, look, subjects)


def _ordered(method: Method, scenes: Sequence[Scene]) -> tuple[Scene, ...]:
    """Returns the scenes that a method is meant for: hard ones last, otherwise fewest steps
    first."""

    def steps(scene: Scene) -> float:
        return scene.duration / min(scene.steps) * system_of(scene).weight

    chosen = [scene for scene in scenes if meant(method, scene)]
    return tuple(sorted(chosen, key=lambda scene: (bool(scene.hard), steps(scene), scene.name)))


def _outcome(name: str, look: Look, subjects: Sequence[Subject]) -> Checked:
    """Returns a check's outcome over all methods: the first failure, else the first pass."""
    outcomes: dict[Status, list[str]] = {"fail": [], "pass": [], "not checked": []}
    for subject in subjects:
        status: Status = "fail"
        try:
            # Output and files of the engine are caught: `writes_nothing` checks for them.
            with TemporaryDirectory() as folder, chdir(folder), captured():
                what = look(subject)
            status = "pass"
        except NotChecked as why:
            status = "not checked"
            what = str(why)
        except AssertionError as why:
            what = str(why)
        except Exception as error:
            what = f"{type(error).__name__}: {error}"
        outcomes[status].append(f"{subject.method.name}: {what}")
    status = next((name for name, shown in outcomes.items() if shown), "not checked")
    first, *others = outcomes[status] or ["no method"]
    more = f" (and {len(others)} more)" if others else ""
    return Checked(name, status, " ".join((first + more).split()))


def _hold(holds: object, why: str) -> None:
    """Raises AssertionError with a reason if a condition is false, under `python -O` too."""
    if not holds:
        raise AssertionError(why)


def builds(subject: Subject) -> str:
    """Checks that every scene that the method is meant for is built, or declared as unsupported."""
    built = 0
    for scene in subject.scenes:
        try:
            simulation = subject.prepared(case_of(scene), subject.step(scene))
        except Unsupported as why:
            declared = expected(scene.name, subject.method.name).verdict == "unsupported"
            _hold(declared, f"it is meant for {scene.name}, and says: {why}")
            continue
        for part in ("run", "stepped"):
            _hold(callable(getattr(simulation, part, None)), f"a simulation has no {part}()")
        built += 1
    if not built:
        raise NotChecked("it is meant for none of the scenes")
    return f"{built} scenes"


def repeats(subject: Subject) -> str:
    """Checks that two runs of one simulation, and a run of a second one, agree to the last bit."""
    case, step = subject.short
    simulation = subject.prepared(case, step)
    first, *others = simulation.run(), simulation.run(), subject.prepared(case, step).run()
    for number, run in enumerate(others, 2):
        for name, values in first.observables.items():
            same = np.array_equal(values, run.observables[name])
            _hold(same, f"{name} of run {number} of {case.scene.name} is not that of run 1")
    return f"3 runs of {case.scene.name}, the same bits"


def samples(subject: Subject) -> str:
    """Checks that samples stand at times of whole steps, from the start to the end, and that each
    sample holds the state at its time, not the state one step earlier or later."""
    case, step = subject.short
    run = subject.run(case, step)
    solver = subject.method.control == "tolerance"
    exact = case.reference.observe(run.times)
    doubt = case.reference.uncertainty(run.times[:1])
    for name in _states(case, run):
        error = run.observables[name] - exact[name]
        allowed = 10.0 * doubt[name][0] + 1e-9 * (np.abs(exact[name]).max() or 1.0)
        off = f"{name} starts {error[0]:.3g} off the start of {case.scene.name}"
        _hold(abs(error[0]) <= allowed, off)
        late = not solver or np.abs(error).max() <= LATE * np.abs(np.diff(exact[name])).max()
        _hold(late, f"{name} is late by much of a sample")
    if not solver:
        _not_late(case, subject.run(case.lasting(step), step), step)
        for sample in {1, len(run.times) // 2}:
            _agree(run, subject.run(case.lasting(float(run.times[sample])), step), sample)
    return f"{len(run.times)} samples of {case.scene.name}"


def _not_late(case: Case, run: Trajectory, step: float) -> None:
    """Checks the first step: an observable whose first two exact changes are equal within 10 %
    changes by the exact amount, within LATE of it. A step's own error is smaller by an order of the
    step. A sample that is one step late is wrong by the whole change."""
    times = np.array([0.0, step, 2.0 * step])
    exact = case.reference.observe(times)
    doubt = case.reference.uncertainty(times)
    for name in _states(case, run):
        change, twice = exact[name][1:] - exact[name][0]
        if abs(change) > 1e3 * doubt[name].max() and abs(twice / change - 2.0) < 0.1:
            late = float(run.observables[name][-1] - exact[name][1]) / float(change)
            _hold(
                abs(late) <= LATE, f"after one step {name} is {late:+.2f} steps ahead of time"
            )


def _agree(run: Trajectory, part: Trajectory, sample: int) -> None:
    """Checks that a shorter run ends with the values that a longer run holds at that sample."""
    for name, values in run.observables.items():
        moved = np.abs(np.diff(values[max(sample - 1, 0) : sample + 2])).max(initial=0.0)
        apart = abs(values[sample] - part.observables[name][-1])
        same = apart <= SAME * moved + 1e-9 * np.abs(values).max(initial=0.0)
        _hold(same, f"{name} at step {part.steps} is not that of a run of {part.steps} steps")


def _states(case: Case, run: Trajectory) -> list[str]:
    """Names of the observables that a run gives and that are coordinates or rates. Forces are left
    out: steps do not change them."""
    return [
        o.name for o in case.system.observables if not o.force and o.name in run.observables
    ]


def writes_nothing(subject: Subject) -> str:
    """Checks that building and running leaves no file and prints nothing."""
    case, step = subject.short
    with captured() as output:
        simulation = subject.prepared(case, step)
        simulation.run()
        simulation.stepped(0.5)
    left = sorted(os.listdir())
    _hold(not left, f"it leaves {', '.join(left[:3])}")
    _hold(not output[0].strip(), f"it prints: {output[0].strip()[:80]}")
    return "no output, no file"


def divergence(subject: Subject) -> str:
    """Checks that a run at far too large steps ends with finite samples, or with the time at which
    the run diverged, and that it raises nothing."""
    if subject.method.control == "tolerance":
        raise NotChecked("it chooses its steps")
    lost = 0
    # The scene with the fewest steps of each system.
    kept = {scene.system: scene for scene in reversed(subject.scenes)}
    for scene in kept.values():
        step = scene.duration / COARSE
        with suppress(Unsupported):
            run = subject.prepared(case_of(scene), step).run()
            why = not_a_trajectory(run)
            _hold(not why, f"{scene.name} at a step of {step:g} s: {why}")
            lost += run.diverged_at is not None
    return f"{lost} of {len(kept)} systems lost at {COARSE} steps in all, and said so"


def cost(subject: Subject) -> str:
    """Checks that a run counts its steps, that `stepped` takes the fraction of the steps asked for,
    and that timed steps cost what steps of a run cost."""
    case, step = subject.short
    run = subject.run(case, step)
    simulation = subject.prepared(case, step)
    full = simulation.stepped(1.0)
    half = simulation.stepped(0.5)
    _hold(simulation.compile_seconds >= 0.0, "compile_seconds is negative")
    for what, of in (("a run", run), ("stepped(1)", full), ("stepped(0.5)", half)):
        _hold(of.steps > 0, f"{what} counts no steps")
        _hold(of.seconds > 0.0, f"{what} takes no time")
    if subject.method.control == "step":
        count = step_count(case.scene.duration, step)
        for part, of in ((1.0, full), (0.5, half)):
            near = abs(of.steps - part * count) <= 2.0 * (1.0 - part)
            _hold(near, f"stepped({part:g}) counts {of.steps} steps of {count}")
    (scene,) = (scene for scene in subject.scenes if scene.name == case.scene.name)
    why = false_cost(case_of(scene), subject.method, step)
    _hold(not why, f"{case.scene.name}: {why}")
    return f"{run.steps} steps of {case.scene.name}"


def order(subject: Subject) -> str:
    """Checks, on three scenes, that the error falls at the declared order or at the order that
    theory predicts for the scene, and that its verdict is as it should be."""
    method = subject.method
    if method.order is None:
        raise NotChecked("it chooses its steps: no order")
    slopes: dict[str, float] = {}
    good = [s for s in subject.scenes if expected(s.name, method.name).verdict == "predicted"]
    for scene in good[:TRIED]:
        study = convergence_study(scene, method, most_steps(scene, "quick"))
        case = case_of(scene)
        judgement = judged(study, case.system, method, case.system.quantities(case)).whole
        right = judgement.verdict in ("predicted", "converges", "pre-asymptotic")
        _hold(right, f"{scene.name}: {judgement.verdict}, {judgement.reason}")
        if study.order is None or judgement.verdict == "pre-asymptotic":
            continue
        wanted = method.order
        least = min(wanted, study.predicted_order.slope) if study.predicted_order else wanted
        low = f"{scene.name}: order {study.order.slope:.2f}, declared {wanted}"
        _hold(study.order.slope >= least - BELOW, low)
        slopes[scene.name] = study.order.slope
        if len(slopes) == ORDERS:
            break
    if not slopes:
        raise NotChecked("no scene shows an order")
    return ", ".join(f"{slope:.2f} on {scene}" for scene, slope in slopes.items())


CHECKS: Mapping[str, Look] = MappingProxyType(
    {
        "builds": builds,
        "repeats itself": repeats,
        "samples at its steps": samples,
        "writes nothing": writes_nothing,
        "reports divergence": divergence,
        "counts its cost": cost,
        "shows its order": order,
    }
)
