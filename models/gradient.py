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
    CENTRAL_OFFSETS,
    OFFSETS_ABOVE,
    OFFSETS_BELOW,
    Neighbours,
    Sensitivity,
)
from plumbob.analytic.sensitivities.phases import Phased, phased_gradients
from plumbob.models.scene import Case, ExactGradients, Parameters, System

NEIGHBOUR_DISTANCE = 1e-3  # distance of the nearest neighbour, relative to the number's size
SHRINK_FACTOR = 0.5  # factor of the distance from one attempt to the next
SMALLEST_STEP = 1e-10  # smallest distance, relative to the number's size
NEIGHBOUR_SIDES = ("below", "above")
NeighboursBySide = tuple[dict[str, Neighbours[Any]], str]
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
    observables = tuple(observable.name for observable in case.system.observables)
    names = of or observables
    known(dict.fromkeys(names), list(observables))
    sensitivities: dict[str, Sensitivity] = {}
    for parameter in by:
        for number in numbers(case, parameter):
            sensitivities[number.name] = _sensitivity(number, times, names)
    return sensitivities


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
        name, _ = _name_and_indices(self.name)
        return name

    @property
    def value(self) -> Any:
        """The number itself; anything else if the parameter is no number."""
        return _nested_item(self.parameters[self.parameter], self.path)

    @property
    def size(self) -> float:
        """Magnitude of the number; its unit if the number is 0."""
        return abs(self.value) or 1.0

    def problem(self, number: float) -> Any:
        """Returns the case's problem with `number` in place of this number; raises ParameterError
        if that changes the structure of the problem."""
        parameters = self._changed(number)
        system = self.case.system
        problem = system.problem(parameters)
        if system.structure(problem) != system.structure(self.case.problem):
            wanted = "one that does not change the sequence of manoeuvres"
            raise ParameterError(self.parameter, parameters[self.parameter], wanted)
        return problem

    def moved(self, number: float) -> Case:
        """Returns the case with `number` in place of this number; raises ParameterError as
        `problem` does."""
        self.problem(number)
        scene = replace(self.case.scene, parameters=self._changed(number))
        return self.case.system.case(scene)

    def _changed(self, number: float) -> Parameters:
        """Returns the case's parameters with `number` in place of this number."""
        value = _with_item(self.parameters[self.parameter], self.path, number)
        return self.case.system.change(self.parameters, {self.parameter: value})


def numbers(case: Case, wanted: str) -> Iterator[Number]:
    """Yields each number that `wanted` means, a parameter or one of its numbers by index; raises
    ParameterError for a name that is unknown, or that the case leaves out."""
    parameter, _ = _name_and_indices(wanted)
    parameters = _parameters_with(case, parameter)
    for name, path in _number_names(parameters, wanted):
        yield Number(case, name, parameters, path)


def _sensitivity(number: Number, times: Array, names: Sequence[str]) -> Sensitivity:
    """Returns the derivatives with respect to one number. If the number can vary on both of its
    sides together, there is one derivative; otherwise one for each side on which it can vary."""
    neighbours, reason = _neighbours_by_side(number)
    system = number.case.system
    gradients = system.sensitivity or _default_gradients(system)
    sensitivities = gradients(list(neighbours.values()), times) if neighbours else []
    undefined = dict.fromkeys(names, np.full(times.shape, np.nan))
    values: dict[str, dict[str, Array]] = {}
    for side, sensitivity in zip(neighbours, sensitivities, strict=True):
        values[side] = {name: sensitivity.values[name] for name in names}
    # If both sides have a derivative each, the larger uncertainty counts.
    uncertainties = [sensitivity.uncertainty for sensitivity in sensitivities] or [undefined]
    uncertainty: dict[str, Array] = {}
    for name in names:
        uncertainty[name] = np.max([side[name] for side in uncertainties], axis=0)
    if "both" in values:
        return Sensitivity(values["both"], uncertainty)
    below, above = (values.get(side, undefined) for side in NEIGHBOUR_SIDES)
    return Sensitivity(undefined, uncertainty, reason, below, above)


def _default_gradients(system: System) -> ExactGradients:
    """Returns the function that computes derivatives for a system that has none of its own. If the
    motion of the system has a variational equation, the function solves it. Otherwise it takes
    differences of the exact motion."""

    def gradients(problems: Sequence[Neighbours[Any]], times: Array) -> list[Sensitivity]:
        """Returns the sensitivities by each parameter; `problems` has the neighbours by one
        parameter each."""
        start = np.zeros(1)
        if isinstance(system.reference(problems[0].here), CertifiedMotion):
            from plumbob.analytic.numerics.smooth.smooth_motion import certified_smooth_motion
            from plumbob.analytic.sensitivities.smooth_motion import smooth_gradients

            def motion(problem: Any) -> Any:
                """Returns the certified motion of a problem with its equations."""
                return certified_smooth_motion(cast(Any, system.reference(problem)))

            return smooth_gradients(motion, problems, times)

        def phased(problem: Any) -> Phased:
            """Returns the exact motion of a problem as one phase."""
            return Phased(system.reference(problem), start)

        motions = [neighbours.each(phased) for neighbours in problems]
        return phased_gradients(motions, times)

    return gradients


def _name_and_indices(name: str) -> tuple[str, tuple[int, ...]]:
    """Returns the name of a parameter and the indices of one of its numbers, of "name[0][1]"."""
    indices = re.findall(r"\[(\d+)\]", name)
    return name.partition("[")[0], tuple(int(index) for index in indices)


def _parameters_with(case: Case, name: str) -> Parameters:
    """Returns the case's parameters, including the parameter `name`. If the scene leaves `name`
    out, it gets the value with which the motion is the same. Raises ParameterError if there is no
    such value."""
    system = case.system
    parameters = case.scene.parameters
    if name not in system.parameters:
        raise ParameterError("by", name, f"one of {nearest(name, list(system.parameters))}")
    if name in parameters:
        return parameters
    # The parameter may belong to another description of the case, such as a body's mass where the
    # scene has a cone's density. Setting one parameter of that description adds all of them.
    for candidate in (name, *system.parameters):
        if candidate in parameters:
            continue
        default = system.left_out.get(candidate, 0.0)
        try:
            changed = system.change(parameters, {candidate: default})
            if name in changed and _is_same_motion(case, changed):
                return changed
        except ParameterError:
            continue
    raise ParameterError("by", name, f"a parameter that {case.scene.name} has")


def _is_same_motion(case: Case, parameters: Parameters) -> bool:
    """Whether other parameters give the same motion, within the uncertainty of the exact answer, at
    three times."""
    times = np.array([0.0, 0.3, 1.0]) * case.scene.duration
    motion = case.system.reference(case.system.problem(parameters)).observe(times)
    exact = case.reference.observe(times)
    uncertainty = case.reference.uncertainty(times)
    for name in exact.keys() & uncertainty.keys():
        difference = np.abs(motion[name] - exact[name])
        if not (difference <= 8 * uncertainty[name]).all():
            return False
    return True


def _number_names(parameters: Parameters, wanted: str) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yields the name and the indices of each number that `wanted` means."""
    name, path = _name_and_indices(wanted)
    try:
        value = _nested_item(parameters[name], path)
    except (IndexError, TypeError):
        raise ParameterError("by", wanted, f"a number of {parameters[name]!r}") from None
    if not isinstance(value, (list, tuple)):
        yield wanted, path
        return
    for index in range(len(value)):
        yield from _number_names(parameters, f"{wanted}[{index}]")


def _nested_item(value: Any, path: tuple[int, ...]) -> Any:
    """Returns the part of a nested sequence at the indices `path`."""
    return reduce(getitem, path, value)


def _with_item(value: Any, path: tuple[int, ...], number: float) -> Any:
    """Returns a nested sequence with the number at the indices `path` replaced."""
    if not path:
        return number
    changed = list(value)
    changed[path[0]] = _with_item(value[path[0]], path[1:], number)
    return tuple(changed)


def _neighbours_by_side(number: Number) -> NeighboursBySide:
    """Returns the problems near one number, by side, and a reason. If the number can vary on both
    sides at once, the side is "both" and the reason empty. Otherwise the sides are those on which
    it can vary; the reason says why it cannot vary on the other."""
    value = number.value
    if isinstance(value, (bool, str)) or not isinstance(value, (int, float)):
        return {}, f"{number.name} = {value!r} is not a number that can vary"
    both = _neighbours(number, CENTRAL_OFFSETS)
    if isinstance(both, Neighbours):
        return {"both": both}, ""
    by_side = {}
    reasons: list[str] = []
    for side, stencil in zip(NEIGHBOUR_SIDES, (OFFSETS_BELOW, OFFSETS_ABOVE), strict=True):
        neighbours = _neighbours(number, stencil)
        if isinstance(neighbours, Neighbours):
            by_side[side] = neighbours
        else:
            reasons.append(str(neighbours))
    return by_side, "; ".join(dict.fromkeys(reasons)) or str(both)


def _neighbours(number: Number, stencil: tuple[int, ...]) -> Neighbours[Any] | ParameterError:
    """Returns the problems at `stencil` multiples of a step from the number. The step shrinks until
    all of them are possible; returns the error if it becomes too small."""
    step = NEIGHBOUR_DISTANCE * number.size
    while True:
        values = [number.value + multiple * step for multiple in stencil]
        try:
            problems = [number.problem(value) for value in values]
            _require_alike(number, problems)
            return Neighbours(tuple(problems), np.array(values) - number.value)
        except ParameterError as error:
            step *= SHRINK_FACTOR
            if step < SMALLEST_STEP * number.size:
                return error


def _require_alike(number: Number, problems: Sequence[Any]) -> None:
    """Raises ParameterError if one of the problems near a number cannot be compared with the
    case's."""
    alike = number.case.system.alike
    if not all(alike(number.case.problem, problem) for problem in problems):
        wanted = "one near which the sequence of a motion's phases is the same"
        raise ParameterError(number.parameter, number.value, wanted)
