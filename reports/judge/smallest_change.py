"""The smallest change of a scene's parameters that the verdict on a method would notice: what its
runs allow at a moment, over what the change does to the exact motion there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plumbob.analytic.left_open import roundings
from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.measurement import Measurement
from plumbob.models.gradient import Number, numbers
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Scene
from plumbob.reports.judge.tightness import Noticed
from plumbob.reports.judge.tolerance import Tolerance
from plumbob.reports.judge.verdict import Judged

# Of a parameter's value, or of one unit where that is zero; the first that moves observables by
# less than PROPORTIONAL of their sizes.
NUDGES = (1e-7, 1e-9, 1e-11, 1e-13)
PROPORTIONAL = 1e-4
SAMPLES = 200  # of a run, on no grid of steps: on none falls a switch that a nudge moves
FREED = "excess"  # gives the start's rate in another way; other changes keep that rate
TINY = 1e-300  # in place of nothing allowed, where the exact value is zero
PLANNED = "capsule-plan"  # whose slider moves as its parameters need
Slopes = Mapping[str, Array]  # {observable: |derivative| at the times, shape (n,)}


def parameters_of(scene: Scene) -> Mapping[str, Number]:
    """The numbers that a scene is given, in its order, but whole ones, by name, with the number of
    the point, and x, y or z; without supports where no normal force is observed, which takes long,
    and none of a plan, which is another plan then."""
    if scene.system == PLANNED:
        return {}
    case = case_of(scene)
    parameters = {name: value for name, value in scene.parameters.items() if name != FREED}
    loads = any(o.name.startswith("normal_force") for o in case.system.observables)
    every = (
        replace(number, parameters=parameters)
        for name in parameters
        if loads or name != "supports"
        for number in numbers(case, name)
    )
    return {_label(number): number for number in every if isinstance(number.value, float)}


def _label(number: Number) -> str:
    if not number.path:
        return number.parameter
    *point, axis = number.path
    return " ".join([number.parameter, *(str(i + 1) for i in point), "xyz"[axis]])


@dataclass(frozen=True)
class Sensitivities:
    """The effect of changed parameters on the exact motion of a `scene`, and the changes that a
    method's runs of it allow."""

    scene: Scene

    @cached_property
    def slopes(self) -> Mapping[str, Slopes]:
        """How much each observable changes per unit of each parameter, its value, or 1 in its SI
        unit where it is zero; without those that cannot be changed."""
        every = {name: self._slopes(number) for name, number in parameters_of(self.scene).items()}
        return {name: slope for name, slope in every.items() if slope is not None}

    def noticed(self, series: ConvergenceStudy, judged: Judged) -> Mapping[str, Noticed]:
        """For each parameter the smallest change that fails a run of `series`: at some moment it
        moves an observable by more than is allowed there, beside what the run differs by already.
        Without parameters that move nothing that is judged; empty where the verdict is not
        `predicted`."""
        least: dict[str, Noticed] = {}
        if judged.whole.verdict != "predicted":
            return least
        for run, verdict in zip(series.measurements, judged.runs, strict=True):
            for name, held in verdict.tolerances.items():
                allowed = self._allowed(run, name, held)
                for parameter, slopes in self.slopes.items():
                    fastest = float((slopes[name] / allowed).max())
                    change = max(1.0 / fastest, ULP) if fastest > 0.0 else math.inf
                    known = least.get(parameter)
                    if change < (known.change if known else math.inf):
                        least[parameter] = Noticed(change, run.step, name)
        return least

    @cached_property
    def _times(self) -> Array:
        """Times [s] over the run, shape (n,), its ends included."""
        inner = (np.arange(SAMPLES) + np.sqrt(0.5)) / SAMPLES
        return np.concatenate([[0.0], inner[:-1], [1.0]]) * self.scene.duration

    @cached_property
    def _exact(self) -> tuple[Mapping[str, Array], Mapping[str, Array]]:
        """The exact motion and its uncertainty."""
        reference = case_of(self.scene).reference
        return reference.observe(self._times), reference.uncertainty(self._times)

    def _slopes(self, parameter: Number) -> Slopes | None:
        """By one difference, less what rounding may make of it: of both motions as much."""
        right, doubt = self._exact
        for nudge in NUDGES:
            if (other := _nudged(parameter, nudge)) is None:
                return None
            observed = other.reference.observe(self._times)
            moved = {name: np.abs(observed[name] - values) for name, values in right.items()}
            sizes = {name: np.abs(values).max() for name, values in right.items()}
            if all(v.max() <= PROPORTIONAL * (sizes[n] or np.inf) for n, v in moved.items()):
                break
        return {name: np.maximum(v - 2.0 * doubt[name], 0.0) / nudge for name, v in moved.items()}

    def _allowed(self, run: Measurement, name: str, held: Tolerance) -> Array:
        """By how much an observable may move at each time before the run fails, at most: what is
        open grows over the run, rounding with the condition of the motion, a series' remainder from
        nothing at the start to its largest, which is taken for all later times."""
        error = run.errors[name]
        predicted, model = error.predicted, error.model_error
        if predicted is None:
            return np.full_like(self._times, max(held.bound + error.largest, TINY))
        rounding = np.maximum.accumulate(self._exact[1][name]) * roundings(run.steps)
        left = np.where(self._times > 0.0, predicted.open, rounding)
        if predicted.for_this_step:
            left = np.minimum(rounding, predicted.open)
        return np.maximum(left + model + np.minimum(predicted.difference, left + model), TINY)


def _nudged(parameter: Number, nudge: float) -> Case | None:
    """The case with a parameter a little larger, or smaller where that is not allowed."""
    for by in (nudge, -nudge):
        try:
            return parameter.at(parameter.value + by * parameter.size)
        except ParameterError:
            continue
    return None
