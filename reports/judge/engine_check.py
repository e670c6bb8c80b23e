"""Checks of an engine's adapter, by running it: that it builds its scenes, repeats itself, samples
at its steps, writes nothing, reports a failed run, counts its steps, and converges at its order."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np

from plumbob.engines.method import Engine, Method, Simulation, Unsupported, meant
from plumbob.engines.registry import unguarded
from plumbob.engines.sampling import step_count
from plumbob.engines.study.convergence import chosen_step_sizes, convergence_study
from plumbob.engines.study.measurement import not_asked_for
from plumbob.engines.study.runner import most_steps
from plumbob.engines.trajectory import Trajectory, not_a_trajectory
from plumbob.models.entry_points import captured
from plumbob.models.registry import case_of, system_of
from plumbob.models.scene import Case, Scene
from plumbob.reports.judge.expectations import expected
from plumbob.reports.judge.verdict import judged

LATE = 0.25  # steps: of a method that converges the first sample is late by less and less of a step
SAME = 1e-3  # of a step's motion: by what runs of different lengths may differ at the same time
LOST = 1e6  # times the motion: a run so far off has diverged
BELOW = 0.3  # by how much an observed order may be lower than the declared one
ORDERS, TRIED = 3, 9  # scenes that the order is to be seen on, and how many are tried for it
STEPS = 1201  # of a run whose samples are looked at: one sample every three steps
COARSE = 8  # steps in a run that is to diverge, if it can

Status = Literal["pass", "fail", "not checked"]


class NotChecked(Exception):
    """Why something cannot be checked for a method."""


@dataclass(frozen=True)
class Checked:
    """The outcome of one check for all methods of an engine."""

    name: str
    status: Status
    detail: str  # what was seen, or the method that fails and why


@dataclass(frozen=True)
class Subject:
    """A method under check, and the scenes that it is meant for, those of fewest steps first."""

    engine: Engine
    method: Method
    scenes: tuple[Scene, ...]

    def prepared(self, case: Case, step: float) -> Simulation:
        """The case in the engine itself, whose errors are raised."""
        return self.engine.prepare(case, self.method, step)

    @property
    def first(self) -> Case:
        """The case of fewest steps that the engine builds; raises NotChecked where there is
        none."""
        for scene in self.scenes:
            case = case_of(scene)
            try:
                self.prepared(case, self.step(scene))
            except Unsupported:
                continue
            return case
        raise NotChecked("it builds no scene")

    def step(self, scene: Scene) -> float:
        """The step [s] that a scene is looked at with, or the tightest tolerance."""
        sizes = chosen_step_sizes(scene, self.method, most_steps(scene, "quick"))
        return sizes[len(sizes) // 2] if self.method.control == "step" else sizes[-1]


Look = Callable[[Subject], str]  # what was seen; raises AssertionError and NotChecked


def check_engine(methods: Sequence[Method], scenes: Sequence[Scene]) -> Iterator[Checked]:
    """The checks of an engine's methods on those of `scenes` that they are meant for, one after the
    other."""
    subjects = [
        Subject(unguarded(method.engine), method, _ordered(method, scenes)) for method in methods
    ]
    for name, look in CHECKS.items():
        yield _outcome(name, look, subjects)


def _ordered(method: Method, scenes: Sequence[Scene]) -> tuple[Scene, ...]:
    """The scenes that a method is meant for, hard ones last, those of fewest steps first."""

    def steps(scene: Scene) -> float:
        return scene.duration / min(scene.steps) * system_of(scene).weight

    chosen = [scene for scene in scenes if meant(method, scene)]
    return tuple(sorted(chosen, key=lambda scene: (bool(scene.hard), steps(scene), scene.name)))


def _outcome(name: str, look: Look, subjects: Sequence[Subject]) -> Checked:
    """A check's outcome over all methods: the first failure, or the first result."""
    passed, without, failed = [], [], []
    for subject in subjects:
        method = subject.method.name
        try:
            with _elsewhere(), captured():  # what it writes is a check of its own
                what = look(subject)
            passed.append(f"{method}: {what}")
        except NotChecked as why:
            without.append(f"{method}: {why}")
        except AssertionError as why:
            failed.append(f"{method}: {why}")
        except Exception as error:
            failed.append(f"{method}: {type(error).__name__}: {error}")
    status: Status = "fail" if failed else "pass" if passed else "not checked"
    shown = failed or passed or without
    more = f" (and {len(shown) - 1} more)" if len(shown) > 1 else ""
    return Checked(name, status, " ".join((shown[0] + more).split()) if shown else "no method")


def _hold(holds: object, why: str) -> None:
    """Raise AssertionError with a reason, whatever the interpreter's options."""
    if not holds:
        raise AssertionError(why)


def builds(subject: Subject) -> str:
    """Every scene that the method is meant for is built, or declared as unsupported."""
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
    """Two runs of one simulation, and a run of another, agree to the last bit."""
    case, step = _short(subject)
    simulation = subject.prepared(case, step)
    runs = [simulation.run(), simulation.run(), subject.prepared(case, step).run()]
    for number, run in enumerate(runs[1:], 2):
        _is_run(run)
        for name, values in runs[0].observables.items():
            same = np.array_equal(values, run.observables[name])
            _hold(same, f"{name} of run {number} of {case.scene.name} is not that of run 1")
    return f"3 runs of {case.scene.name}, the same bits"


def samples(subject: Subject) -> str:
    """Samples stand at times of whole steps, from the start to the end, and hold what the engine
    has reached by then: not a step later, nor earlier."""
    long, step = _short(subject)
    case = case_of(long.scene)
    if subject.method.control == "tolerance":
        return _samples_of_a_solver(subject, case, step)
    run = subject.prepared(long, step).run()
    _is_asked_for(subject, long, step, run)
    indices = np.rint(run.times / step).astype(int)
    _starts_right(case, run)
    for index in {1, int(indices[1]), int(indices[len(indices) // 2])}:
        part = subject.prepared(case.lasting(index * step), step).run()
        _is_run(part)
        if index == 1:
            _not_late(case, part, step)
        if index in indices:
            _agree(run, part, int(np.flatnonzero(indices == index)[0]), index)
    return f"{len(indices)} samples of {case.scene.name}, one step as long as the other"


def _starts_right(case: Case, run: Trajectory) -> None:
    """The first sample is the start of the scene, within its rounding."""
    start = np.zeros(1)
    exact, doubt = case.reference.observe(start), case.reference.uncertainty(start)
    spans = case.reference.observe(np.linspace(0.0, case.scene.duration, 101))
    for observable in case.system.observables:
        if (name := observable.name) in _states(case) and name in run.observables:
            span = float(np.abs(spans[name]).max()) or 1.0
            allowed = 10.0 * float(doubt[name][0]) + 1e-9 * span
            apart = abs(float(run.observables[name][0] - exact[name][0]))
            _hold(apart <= allowed, f"{name} starts {apart:.3g} off the start of {case.scene.name}")


def _not_late(case: Case, run: Trajectory, step: float) -> None:
    """After one step, what changes evenly at the start has changed by the exact amount, within part
    of it: a step's own error is smaller by an order of the step, a sample's that is a step late is
    as large as the change."""
    exact = case.reference.observe(np.array([0.0, step, 2.0 * step]))
    doubt = case.reference.uncertainty(np.array([0.0, step, 2.0 * step]))
    for name in _states(case):
        change, twice = exact[name][1] - exact[name][0], exact[name][2] - exact[name][0]
        even = abs(change) > 1e3 * doubt[name].max() and abs(twice / change - 2.0) < 0.1
        if even and name in run.observables:
            late = float(run.observables[name][-1] - exact[name][1]) / float(change)
            _hold(abs(late) <= LATE, f"after one step {name} is {late:+.2f} steps ahead of time")


def _agree(run: Trajectory, part: Trajectory, sample: int, index: int) -> None:
    """A run that ends at a sample of a longer one ends with what that holds."""
    for name, values in run.observables.items():
        moved = float(np.abs(np.diff(values[max(sample - 1, 0) : sample + 2])).max(initial=0.0))
        apart = abs(float(values[sample] - part.observables[name][-1]))
        scale = float(np.abs(values).max(initial=0.0))
        allowed = SAME * moved + 1e-9 * scale
        _hold(apart <= allowed, f"{name} at step {index} is not that of a run of {index} steps")


def _states(case: Case) -> tuple[str, ...]:
    """Observables that are coordinates and rates, which steps change; forces are read off."""
    return tuple(o.name for o in case.system.observables if not o.force)


def _samples_of_a_solver(subject: Subject, case: Case, tolerance: float) -> str:
    run = subject.prepared(case, tolerance).run()
    _is_asked_for(subject, case, tolerance, run)
    _starts_right(case, run)
    exact = case.reference.observe(run.times)
    for name in _states(case):
        if name in run.observables:
            error = np.abs(run.observables[name] - exact[name])
            between = np.abs(np.diff(exact[name])).max()
            _hold(error.max() <= LATE * between, f"{name} is late by much of a sample")
    return f"{len(run.times)} samples of {case.scene.name}"


def writes_nothing(subject: Subject) -> str:
    """Building and running leaves no file and writes nothing to stdout or stderr."""
    case, step = _short(subject)
    with _elsewhere() as folder, captured() as output:
        simulation = subject.prepared(case, step)
        simulation.run()
        simulation.stepped(0.5)
        left = sorted(os.listdir(folder))
    _hold(not left, f"it leaves {', '.join(left[:3])}")
    _hold(not output[0].strip(), f"it prints: {output[0].strip()[:80]}")
    return "no output, no file"


@contextmanager
def _elsewhere() -> Iterator[str]:
    """An empty folder to work in."""
    back = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield folder
        finally:
            os.chdir(back)


def divergence(subject: Subject) -> str:
    """At steps far too large a run ends with finite samples, or with the time at which it was lost;
    it raises nothing."""
    if subject.method.control == "tolerance":
        raise NotChecked("it chooses its steps")
    lost = 0
    kept = {scene.system: scene for scene in reversed(subject.scenes)}  # one scene a system
    for scene in kept.values():
        case = case_of(scene)
        try:
            run = subject.prepared(case, scene.duration / COARSE).run()
        except Unsupported:
            continue
        where = f"{scene.name} at a step of {scene.duration / COARSE:g} s"
        _is_run(run, where)
        if run.diverged_at is not None:
            early = not len(run.times) or float(run.times[-1]) <= run.diverged_at
            _hold(early, f"{where}: samples after it is lost")
            lost += 1
            continue
        spans = case.reference.observe(np.linspace(0.0, scene.duration, 101))
        for name in _states(case):
            far = float(np.abs(run.observables.get(name, np.zeros(1))).max(initial=0.0))
            span = float(np.abs(spans[name]).max()) or 1.0
            _hold(far <= LOST * span, f"{where}: {name} reaches {far:.2g}, and is not lost")
    return f"{lost} of {len(kept)} systems lost at {COARSE} steps in all, and said so"


def cost(subject: Subject) -> str:
    """A run counts its steps, and the steps that are timed alone are those of the fraction asked
    for."""
    case, step = _short(subject)
    simulation = subject.prepared(case, step)
    run, full, half = simulation.run(), simulation.stepped(1.0), simulation.stepped(0.5)
    _is_asked_for(subject, case, step, run)
    _hold(simulation.compile_seconds >= 0.0, "compile_seconds is negative")
    for what, counted, seconds in (
        ("a run", run.steps, run.seconds),
        ("stepped(1)", full.steps, full.seconds),
        ("stepped(0.5)", half.steps, half.seconds),
    ):
        _hold(counted > 0, f"{what} counts no steps")
        _hold(seconds > 0.0, f"{what} takes no time")
    if subject.method.control == "step":
        count = step_count(case.scene.duration, step)
        _hold(full.steps == count, f"stepped(1) counts {full.steps} steps of {count}")
        near = abs(half.steps - count / 2) <= 1
        _hold(near, f"stepped(0.5) counts {half.steps} steps of {count}")
    return f"{run.steps} steps of {case.scene.name}"


def order(subject: Subject) -> str:
    """The error falls at the declared order, or at the one that theory predicts for the scene, and
    is what theory says of it, on three scenes."""
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


def _short(subject: Subject) -> tuple[Case, float]:
    """The case of fewest steps, no longer than the steps that are looked at, and the step [s]."""
    case = subject.first
    step = subject.step(case.scene)
    if subject.method.control == "tolerance":
        return case, step
    return case.lasting(min(STEPS, round(case.scene.duration / step)) * step), step


def _is_run(run: Trajectory, where: str = "a run") -> None:
    why = not_a_trajectory(run)
    _hold(not why, f"{where}: {why}")


def _is_asked_for(subject: Subject, case: Case, step: float, run: Trajectory) -> None:
    """A run is one, with the samples, the end and the count of steps that were asked for."""
    _is_run(run)
    why = not_asked_for(case, subject.method, step, run)
    _hold(not why, f"a run of {case.scene.name}: {why}")


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
