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
from plumbob.reports.commands.arguments.budget import certify

ANGLE = Observable("theta", "rad")


def command(chosen: argparse.Namespace) -> int:
    """Print the observables at the times wanted, and what else is exact."""
    changed = chosen.changes
    asked = changed | ({"times": chosen.times} if chosen.times else {})
    with values.representable(asked, chosen):
        scene = find_scene(chosen.scene, changed)
        times = np.array(chosen.times or np.linspace(0, scene.duration, 11))
        case = case_of(scene)
        certify(case, float(times.max()), chosen.budget)
        by_angle = _over_angles(case, chosen.angles)
        also = case.system.also(case.problem, times)
        observables = case.reference.observe(times)
        uncertainty = _uncertainty(case.reference, times)
        facts = {name: _plain(value) for name, value in case.system.facts(case.problem).items()}
    values.all_finite(asked, observables, uncertainty)
    answer: dict[str, Any] = {
        "scene": scene.name,
        "parameters": scene.parameters,
        "times": times,
        "observables": observables,
        "uncertainty": uncertainty,
        **({"also": _named(also)} if also else {}),
        **({"by_angle": _named(by_angle)} if by_angle else {}),
        **facts,
    }
    table = by_angle or ({Observable("t", "s"): times, **also} if also else {})
    columns = [
        [_held(*pair) for pair in zip(series.tolist(), uncertainty[name].tolist(), strict=True)]
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
        text=_text,
    )
    return 0


def _uncertainty(reference: Reference, times: Array) -> dict[str, Array]:
    """The uncertainty in double precision at each of `times` [s] alone: asked for together, all
    would have that of the latest."""
    each = [reference.uncertainty(times[i : i + 1]) for i in range(times.size)]
    return {name: np.concatenate([values[name] for values in each]) for name in each[0]}


def _unit(name: str, known: Sequence[Observable]) -> str:
    """The unit of an observed value: its own, that of what it is a rate of, or an angle's."""
    of, _, last = name.rpartition("_")
    own = [o.unit for o in known if o.name == name]
    if not own and last in ("dot", "rate"):
        return f"{_unit(of, known)}/s"
    return own[0] if own else "rad" if "angle" in name else ""


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def _text(value: Any) -> str:
    value = _plain(value)
    return repr(float(value) + 0.0) if isinstance(value, float) else str(value)  # no -0.0


def _held(value: float, uncertainty: float) -> str:
    """The digits of `value` that its uncertainty leaves; where it leaves none, both numbers."""
    if not uncertainty > 0.0 or not math.isfinite(value):
        return _text(value)
    last = math.ceil(math.log10(uncertainty))  # decimal place
    digits = 1 + math.floor(math.log10(abs(value))) - last if value else 0
    if digits < 1:
        return f"{value + 0.0:.1g} ± {uncertainty:.1g}"
    return f"{value:.{digits}g}" if digits < 17 else _text(value)


def _named(answers: Mapping[Observable, Array]) -> dict[str, Array]:
    """The answers by their names, as JSON has them."""
    return {observable.name: values for observable, values in answers.items()}


def _over_angles(case: Case, theta: list[float] | None) -> Mapping[Observable, Array]:
    """The answers of `case` at angles [rad], the angles first; empty without. Raises
    ParameterError."""
    if theta is None:
        return {}
    if case.system.by_angle is None:
        none = f"left out: {case.system.name} has no answers over an angle"
        raise ParameterError("angles", theta, none)
    return {ANGLE: np.array(theta), **case.system.by_angle(case.problem, np.array(theta))}
