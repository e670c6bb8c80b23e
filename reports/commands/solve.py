"""plumbob solve: the exact answer of a scene, without any engine."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array, Reference
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case, Observable
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.shared.budget import certify

ANGLE = Observable("theta", "rad")


def command(chosen: argparse.Namespace) -> int:
    """Prints the observables at the chosen times, and the other exact answers of the scene."""
    changed = chosen.changes
    asked = changed | ({"times": chosen.times} if chosen.times else {})
    with values.representable(asked, chosen):
        scene = find_scene(chosen.scene, changed)
        times = np.array(chosen.times or np.linspace(0, scene.duration, 11))
        case = case_of(scene)
        certify(case, float(times.max()), chosen.budget)
        by_angle = _answers_at_angles(case, chosen.angles)
        also = case.system.also(case.problem, times)
        observables = case.reference.observe(times)
        uncertainty = _uncertainty(case.reference, times)
        facts = {
            name: _plain_value(value) for name, value in case.system.facts(case.problem).items()
        }
    values.all_finite(asked, observables, uncertainty)
    answer: dict[str, Any] = {
        "scene": scene.name,
        "parameters": scene.parameters,
        "times": times,
        "observables": observables,
        "uncertainty": uncertainty,
    }
    if also:
        answer["also"] = _by_name(also)
    if by_angle:
        answer["by_angle"] = _by_name(by_angle)
    answer |= facts
    table = by_angle or ({Observable("t", "s"): times, **also} if also else {})
    columns = [
        list(map(_significant_digits, series.tolist(), uncertainty[name].tolist()))
        for name, series in observables.items()
    ]
    values.show(
        chosen,
        answer,
        "solve",
        scene=scene,
        facts={"parameters": scene.parameters, **facts},
        heads=list(table),
        table=np.transpose(list(table.values())).tolist(),
        held=[] if by_angle else list(observables),
        units={name: _unit(name, case.system.observables) for name in observables},
        rows=list(zip(times.tolist(), *columns, strict=True)),
        text=_value_text,
    )
    return 0


def _uncertainty(reference: Reference, times: Array) -> dict[str, Array]:
    """Returns the uncertainty of each observable in double precision, shape (times,). Each of the
    `times` [s] is asked for by itself: asked for together, all would have the uncertainty of the
    latest."""
    by_time = [reference.uncertainty(times[i : i + 1]) for i in range(times.size)]
    names = by_time[0]
    return {name: np.concatenate([signals[name] for signals in by_time]) for name in names}


def _unit(name: str, known: Sequence[Observable]) -> str:
    """Returns the unit of an observable: the declared unit; for "x_dot" or "x_rate" the unit of "x"
    per second; rad if the name contains "angle"; else an empty text."""
    for observable in known:
        if observable.name == name:
            return observable.unit
    quantity, _, suffix = name.rpartition("_")
    if suffix in ("dot", "rate"):
        return f"{_unit(quantity, known)}/s"
    return "rad" if "angle" in name else ""


def _plain_value(value: Any) -> Any:
    """Returns an array as a list, and any other value unchanged."""
    return value.tolist() if isinstance(value, np.ndarray) else value


def _value_text(value: Any) -> str:
    """Returns a value as text, a number with all its digits."""
    value = _plain_value(value)
    if isinstance(value, float):
        return repr(float(value) + 0.0)  # adding 0.0 turns -0.0 into 0.0
    return str(value)


def _significant_digits(value: float, uncertainty: float) -> str:
    """Returns `value` with the digits that its uncertainty leaves. If no digit is certain, returns
    the value and its uncertainty."""
    if not uncertainty > 0.0 or not math.isfinite(value):
        return _value_text(value)
    last_place = math.ceil(math.log10(uncertainty))  # decimal place of the last digit
    digits = 1 + math.floor(math.log10(abs(value))) - last_place if value else 0
    if digits < 1:
        return f"{value + 0.0:.1g} ± {uncertainty:.1g}"
    return f"{value:.{digits}g}" if digits < 17 else _value_text(value)


def _by_name(answers: Mapping[Observable, Array]) -> dict[str, Array]:
    """Returns the answers by the names of their observables, as JSON has them."""
    return {observable.name: values for observable, values in answers.items()}


def _answers_at_angles(case: Case, theta: list[float] | None) -> Mapping[Observable, Array]:
    """Returns the angles `theta` [rad] and the answers of `case` at these angles; an empty mapping
    if no angles are given. Raises ParameterError."""
    if theta is None:
        return {}
    if case.system.by_angle is None:
        expected = f"left out: {case.system.name} has no answers over an angle"
        raise ParameterError("angles", theta, expected)
    angles = np.array(theta)
    return {ANGLE: angles, **case.system.by_angle(case.problem, angles)}
