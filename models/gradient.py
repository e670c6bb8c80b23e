"""Exact derivatives of a case's observables with respect to its parameters, including those of the
start."""

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

STEP = 1e-3  # distance of the nearest neighbour, relative to the number's size
SHRINK = 0.5  # factor of the distance from one attempt to the next
SMALLEST = 1e-10  # smallest distance, relative to the number's size
SIDES = ("below", "above")
Beside = tuple[dict[str, Neighbours[Any]], str]
"""{side: neighbours of a number}, and the reason why there is no side "both"."""


def exact_gradient(
    case: Case, by: Sequence[str], times: Array, of: Sequence[str] = ()
) -> Mapping[str, Sensitivity]:
    """Returns the derivatives of the observables `of` (none named: all) at `times` [s], shape (n,),
    with respect to each parameter in `by`, the other parameters fixed. A parameter has the name of
    `--set`. An index selects one of several numbers: "supports[0][1]"; without an index each number
    of the parameter gives an entry. At a time at which something switches, the derivatives are
    those of the interval that begins there.

    Raises ParameterError for a name that is unknown, or that the case leaves out.

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
    name: str  # name with indices, if the parameter has several numbers
    parameters: Parameters  # parameters of the case, including the number's own
    path: tuple[int, ...]  # indices of the number in its parameter

    @property
    def parameter(self) -> str:
        """Name of the parameter that the number belongs to."""
        return _parsed(self.name)[0]

    @property
    def value(self) -> Any:
        """The number itself; anything else if the parameter is no number."""
        return _at(self.parameters[self.parameter], self.path)

    @property
    def size(self) -> float:
        """Magnitude of the number; its unit if the number is 0."""
        return abs(self.value) or 1.0

    def problem(self, number: float) -> Any:
        """Returns the case's problem with `number` in place of this number; raises ParameterError
        if that changes the structure of the problem."""
        changed = self._changed(number)
        system = self.case.system
        moved = system.problem(changed)
        if system.structure(moved) != system.structure(self.case.problem):
            only = "one that does not change the sequence of manoeuvres"
            raise ParameterError(self.parameter, changed[self.parameter], only)
        return moved

    def moved(self, number: float) -> Case:
        """Returns the case with `number` in place of this number; raises ParameterError as
        `problem` does."""
        self.problem(number)
        scene = replace(self.case.scene, parameters=self._changed(number))
        return self.case.system.case(scene)

    def _changed(self, number: float) -> Parameters:
        """Returns the case's parameters with `number` in place of this number."""
        value = _with(self.parameters[self.parameter], self.path, number)
        return self.case.system.change(self.parameters, {self.parameter: value})


def numbers(case: Case, wanted: str) -> Iterator[Number]:
    """Yields each number that `wanted` means, a parameter or one of its numbers by index; raises
    ParameterError for a name that is unknown, or that the case leaves out."""
    parameters = _complete(case, _parsed(wanted)[0])
    for name, path in _numbers(parameters, wanted):
        yield Number(case, name, parameters, path)


def _sensitivity(number: Number, times: Array, names: Sequence[str]) -> Sensitivity:
    """Returns the derivatives with respect to one number. If the number can vary on both of its
    sides together, there is one derivative; otherwise one for each side on which it can vary."""
    (sides, why) = _beside(number)
    system = number.case.system
    gradients = system.sensitivity or _general(system)
    found = dict(
        zip(sides, gradients(list(sides.values()), times) if sides else (), strict=True)
    )
    nothing = dict.fromkeys(names, np.full(times.shape, np.nan))
    values = {side: {n: one.values[n] for n in names} for side, one in found.items()}
    # If both sides have a derivative each, the larger uncertainty counts.
    unsure = [one.uncertainty for one in found.values()] or [nothing]
    uncertain = {n: np.max([one[n] for one in unsure], axis=0) for n in names}
    if "both" in found:
        return Sensitivity(values["both"], uncertain)
    below, above = (values.get(side, nothing) for side in SIDES)
    return Sensitivity(nothing, uncertain, why, below, above)


def _general(system: System) -> Gradients:
    """Returns the derivatives' function for a system that has none of its own. If the system's
    motion has a variational equation, the function solves it. Otherwise it takes differences of the
    exact motion."""

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
    """Returns the name of a parameter and the indices of one of its numbers, of "name[0][1]"."""
    indices = re.findall(r"\[(\d+)\]", name)
    return name.partition("[")[0], tuple(int(index) for index in indices)


def _complete(case: Case, name: str) -> Parameters:
    """Returns the case's parameters, including the parameter `name`. If the scene leaves `name`
    out, it gets the value with which the motion is the same. Raises ParameterError if there is no
    such value."""
    system = case.system
    parameters = case.scene.parameters
    if name not in system.parameters:
        raise ParameterError("by", name, f"one of {nearest(name, list(system.parameters))}")
    if name in parameters:
        return parameters
    # The parameter may belong to another description of the case, whose other parameters come with
    # it: setting one of those may bring `name`.
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
    """Whether other parameters give the same motion, within the uncertainty of the exact answer, at
    three times."""
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
    """Yields the name and the indices of each number that `wanted` means."""
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
    """Returns the part of a nested sequence at the indices `path`."""
    return reduce(getitem, path, value)


def _with(value: Any, path: tuple[int, ...], number: float) -> Any:
    """Returns a nested sequence with the number at the indices `path` replaced."""
    if not path:
        return number
    changed = list(value)
    changed[path[0]] = _with(value[path[0]], path[1:], number)
    return tuple(changed)


def _beside(of: Number) -> Beside:
    """Returns the problems near one number, by side, and a reason. If the number can vary on both
    sides at once, the side is "both" and the reason empty. Otherwise the sides are those on which
    it can vary; the reason says why it cannot vary on the other."""
    number = of.value
    system = of.case.system
    if isinstance(number, (bool, str)) or not isinstance(number, (int, float)):
        return {}, f"{of.name} = {number!r} is not a number that can vary"

    def neighbours(stencil: tuple[int, ...]) -> Neighbours[Any] | ParameterError:
        """Returns the problems at `stencil` multiples of a step from the number. The step shrinks
        until all of them are possible; returns the error if it becomes too small."""
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
