"""Exact derivatives of a case's observables by its parameters, the start among them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import getitem
from typing import Any, cast

import numpy as np

from plumbob.analytic.numerics.smooth.certified_motion import CertifiedMotion
from plumbob.analytic.parameters import ParameterError, known, nearest
from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities.neighbours import (
    ABOVE,
    BELOW,
    CENTRAL,
    Neighbours,
    Sensitivity,
)
from plumbob.analytic.sensitivities.phases import Phased, phased_gradients
from plumbob.models.scene import Case, Gradients, Parameters, System

STEP = 1e-3  # of a parameter, or of its unit where that is 0, to the nearest neighbour
SHRINK = 0.5  # from one attempt to the next, until all neighbours are possible
SMALLEST = 1e-10
SIDES = ("below", "above")
Beside = tuple[dict[str, Neighbours[Any]], str]
"""The neighbours on both sides of one number, else on either, and why not on both."""


def exact_gradient(
    case: Case, by: Sequence[str], times: Array, of: Sequence[str] = ()
) -> Mapping[str, Sensitivity]:
    """Derivatives of the observables `of` (none named: all) at `times` [s], shape (n,), by each
    parameter in `by`, at fixed values of the others. A parameter has the name of `--set`, one
    number of several an index: "supports[0][1]"; without an index all its numbers are meant. At a
    time at which something switches they are those of the interval that begins there.

    Raises ParameterError for a name that is unknown or that the case leaves out.

    >>> from plumbob.models.registry import case_of, scene
    >>> case = case_of(scene("capsule-line/heading-030"))
    >>> found = exact_gradient(case, ["friction"], np.array([0.15]), ["displacement"])
    >>> print(f"{found['friction'].values['displacement'][0]:.7f} m")
    0.0196745 m
    """
    times = np.asarray(times, dtype=np.float64)
    names = of or tuple(observable.name for observable in case.system.observables)
    known(dict.fromkeys(names), [observable.name for observable in case.system.observables])
    wanted = (number for name in by for number in numbers(case, name))
    return {number.name: _sensitivity(number, times, names) for number in wanted}


@dataclass(frozen=True)
class Number:
    """One number among a case's parameters, which may vary."""

    case: Case
    name: str  # as it was asked for, with an index where a parameter has several
    parameters: Parameters  # of the case, with this one where a scene leaves it out
    path: tuple[int, ...]

    @property
    def parameter(self) -> str:
        """The name of the parameter that it is of."""
        return _parsed(self.name)[0]

    @property
    def value(self) -> Any:
        """The number itself, or what else is there."""
        return _at(self.parameters[self.parameter], self.path)

    @property
    def size(self) -> float:
        """Its magnitude, or its unit where it is 0."""
        return abs(self.value) or 1.0

    def problem(self, number: float) -> Any:
        """The problem with this number in its place; raises ParameterError where it is not one of
        the same kind."""
        changed = self._changed(number)
        system = self.case.system
        moved = system.problem(changed)
        if system.structure(moved) != system.structure(self.case.problem):
            only = "one that does not change the sequence of manoeuvres"
            raise ParameterError(self.parameter, changed[self.parameter], only)
        return moved

    def moved(self, number: float) -> Case:
        """The case with this number in its place; raises ParameterError as `problem` does."""
        self.problem(number)
        scene = replace(self.case.scene, parameters=self._changed(number))
        return self.case.system.case(scene)

    def _changed(self, number: float) -> Parameters:
        value = _with(self.parameters[self.parameter], self.path, number)
        return self.case.system.change(self.parameters, {self.parameter: value})


def numbers(case: Case, wanted: str) -> Iterator[Number]:
    """Each number that is meant, one of several by its index; raises ParameterError for a name that
    is unknown or that the case leaves out."""
    parameters = _complete(case, _parsed(wanted)[0])
    for name, path in _numbers(parameters, wanted):
        yield Number(case, name, parameters, path)


def _sensitivity(number: Number, times: Array, names: Sequence[str]) -> Sensitivity:
    """The derivatives by one number, on both of its sides or on one."""
    (sides, why) = _beside(number)
    system = number.case.system
    gradients = system.sensitivity or _general(system)
    found = dict(
        zip(sides, gradients(list(sides.values()), times) if sides else (), strict=True)
    )
    nothing = dict.fromkeys(names, np.full(times.shape, np.nan))
    values = {side: {n: one.values[n] for n in names} for side, one in found.items()}
    # Where there are both sides apart, the larger of their uncertainties.
    unsure = [one.uncertainty for one in found.values()] or [nothing]
    uncertain = {n: np.max([one[n] for one in unsure], axis=0) for n in names}
    if "both" in found:
        return Sensitivity(values["both"], uncertain)
    below, above = (values.get(side, nothing) for side in SIDES)
    return Sensitivity(nothing, uncertain, why, below, above)


def _general(system: System) -> Gradients:
    """For a system that does not say how: its variational equation where its motion has one, else
    stencils of the exact motion itself."""

    def gradients(problems: Sequence[Neighbours[Any]], times: Array) -> list[Sensitivity]:
        start = np.zeros(1)
        if isinstance(system.reference(problems[0].here), CertifiedMotion):
            from plumbob.analytic.numerics.smooth.smooth_motion import certified
            from plumbob.analytic.sensitivities.smooth_motion import smooth_gradients

            return smooth_gradients(
                lambda p: certified(cast(Any, system.reference(p))), problems, times
            )
        motions = [one.each(lambda p: Phased(system.reference(p), start)) for one in problems]
        return phased_gradients(motions, times)

    return gradients


def _parsed(name: str) -> tuple[str, tuple[int, ...]]:
    """A parameter and the indices of one of its numbers."""
    indices = re.findall(r"\[(\d+)\]", name)
    return name.partition("[")[0], tuple(int(index) for index in indices)


def _complete(case: Case, name: str) -> Parameters:
    """The case's parameters with the value that `name` has where it is left out: that with which
    the motion is the same."""
    system = case.system
    parameters = case.scene.parameters
    if name not in system.parameters:
        raise ParameterError("by", name, f"one of {nearest(name, list(system.parameters))}")
    if name in parameters:
        return parameters
    # A left out parameter of another description of the case comes with the rest of that.
    for other in (name, *system.parameters):
        if other in parameters:
            continue
        try:
            changed = system.change(parameters, {other: system.left_out.get(other, 0.0)})
            if name in changed and _same(case, changed):
                return changed
        except ParameterError:
            continue
    raise ParameterError("by", name, f"a parameter that {case.scene.name} has")


def _same(case: Case, parameters: Parameters) -> bool:
    ends = np.array([0.0, 0.3, 1.0]) * case.scene.duration
    motion = case.system.reference(case.system.problem(parameters)).observe(ends)
    exact = case.reference.observe(ends)
    allowed = case.reference.uncertainty(ends)
    return all(
        bool((np.abs(motion[name] - values) <= 8 * allowed[name]).all())
        for name, values in exact.items()
        if name in allowed
    )


def _numbers(parameters: Parameters, wanted: str) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Each number that is meant, by name, with its indices."""
    name, path = _parsed(wanted)
    try:
        value = _at(parameters[name], path)
    except (IndexError, TypeError):
        raise ParameterError("by", wanted, f"a number of {parameters[name]!r}") from None
    if not isinstance(value, (list, tuple)):
        yield wanted, path
        return
    for index in range(len(value)):
        yield from _numbers(parameters, f"{wanted}[{index}]")


def _at(value: Any, path: tuple[int, ...]) -> Any:
    return reduce(getitem, path, value)


def _with(value: Any, path: tuple[int, ...], number: float) -> Any:
    """A value with the number at the indices `path` replaced."""
    if not path:
        return number
    changed = list(value)
    changed[path[0]] = _with(value[path[0]], path[1:], number)
    return tuple(changed)


def _beside(of: Number) -> Beside:
    """The neighbours on both sides of one number, else on either, and why not on both."""
    number = of.value
    system = of.case.system
    if isinstance(number, (bool, str)) or not isinstance(number, (int, float)):
        return {}, f"{of.name} = {number!r} is not a number that can vary"

    def neighbours(stencil: tuple[int, ...]) -> Neighbours[Any] | ParameterError:
        step = STEP * of.size
        while True:
            values = [number + k * step for k in stencil]
            try:
                moved = [of.problem(value) for value in values]
                if not all(system.alike(of.case.problem, each) for each in moved):
                    only = "one near which the sequence of a motion's phases is the same"
                    raise ParameterError(of.parameter, number, only)
                return Neighbours(tuple(moved), np.array(values) - number)
            except ParameterError as error:
                step *= SHRINK
                if step < SMALLEST * of.size:
                    return error

    both = neighbours(CENTRAL)
    if isinstance(both, Neighbours):
        return {"both": both}, ""
    found = {}
    why = list[str]()
    for side, stencil in zip(SIDES, (BELOW, ABOVE), strict=True):
        one = neighbours(stencil)
        if isinstance(one, Neighbours):
            found[side] = one
        else:
            why.append(str(one))
    return found, "; ".join(dict.fromkeys(why)) or str(both)
