"""Converts dataclasses to JSON and back: floats to the last bit, arrays as compressed bytes."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType, NoneType
from typing import Any, TypeVar, get_origin

import cattrs
import numpy as np
from cattrs.gen import make_dict_structure_fn, make_dict_unstructure_fn, override

from plumbob.analytic.reference import Array
from plumbob.engines.study.results import Study, TaskResult
from plumbob.models.border import shortened

StoredItem = TypeVar("StoredItem")
DOUBLES = np.dtype("<f8")
# The name by which each class of answers and requests is stored, and the place of that class below
# plumbob.engines. A name never changes; if a class moves, its place changes here. Older studies
# hold the place of a class, "study.cost.SceneCosts": the last word of a place is the name.
KINDS = MappingProxyType(
    {
        "Analysed": "study.results.Analysed",
        "ConvergenceStudy": "study.convergence.ConvergenceStudy",
        "DrawingRequest": "study.extra_runs.DrawingRequest",
        "ExtraRun": "study.extra_runs.ExtraRun",
        "GradientSearch": "study.gradient.GradientSearch",
        "Gradients": "study.gradient.Gradients",
        "Identification": "study.identification.Identification",
        "LoopSearch": "study.loop_limits.LoopSearch",
        "LongRunSearch": "study.long_runs.LongRunSearch",
        "MeasuredLongRun": "study.long_runs.MeasuredLongRun",
        "Measurement": "study.measurement.Measurement",
        "ModelRead": "study.model_reading.ModelRead",
        "ModelReading": "study.model_reading.ModelReading",
        "ParameterFit": "study.identification.ParameterFit",
        "SceneCosts": "study.cost.SceneCosts",
        "SceneDrawing": "drawn_mechanism.SceneDrawing",
        "Stability": "study.stability.SceneLimits",
        "StabilitySearch": "study.stability.StabilitySearch",
        "StepRun": "study.extra_runs.StepRun",
        "Trajectory": "trajectory.Trajectory",
        "Trimming": "abilities.Trimming",
        "TrimmingRun": "study.extra_runs.TrimmingRun",
    }
)
ENGINES = "plumbob.engines."
STORED_SEPARATELY = override(omit=True)  # leaves out a field that is stored in another way


def to_json(item: Any) -> str:
    """The JSON text of a dataclass or a JSON value. A float is the shortest text that reads back as
    the same float; NaN, Infinity and -Infinity are these words."""
    return json.dumps(unstructured(item))


def unstructured(item: Any) -> Any:
    """The JSON values of an item; `restored` is the inverse."""
    return _converter().unstructure(item)


def from_json(text: str, kind: type[StoredItem]) -> StoredItem:
    """The item of this kind whose text `to_json` wrote; raises ValueError if the text is not
    one."""
    try:
        values = json.loads(text)
    except Exception as error:  # a damaged text may raise any exception
        raise ValueError(f"no {kind.__name__}: {error}") from None
    return restored(values, kind)


def restored(values: Any, kind: type[StoredItem]) -> StoredItem:
    """The item of this kind with these JSON values; raises ValueError if they do not fit."""
    try:
        return _converter().structure(values, kind)
    except Exception as error:  # damaged values may raise any exception
        raise ValueError(f"no {kind.__name__}: {error}") from None


@cache
def _converter() -> cattrs.Converter:
    """A converter for stored items: dataclasses, read-only mappings, numpy's numbers and arrays,
    answers to requests, and studies without their results."""
    made = cattrs.Converter(detailed_validation=False)
    made.register_unstructure_hook(MappingProxyType, lambda m: made.unstructure(dict(m)))
    made.register_unstructure_hook(np.generic, lambda value: value.item())
    made.register_structure_hook_func(
        lambda kind: kind is Any, lambda value, _: hashable(value)
    )
    # Most of a store is such tuples, for which cattrs alone takes ten times as long.
    made.register_structure_hook_func(
        lambda kind: kind == tuple[float, ...], lambda values, _: tuple(map(float, values))
    )
    # cattrs calls a field's own type: str() and bool() take anything, int() and float() do not.
    for kind in (str, bool):
        made.register_structure_hook(kind, _as_declared)
    # cattrs does not resolve the types of a named tuple's fields, which hold JSON values.
    made.register_structure_hook_func(
        lambda kind: hasattr(kind, "_fields"), lambda values, kind: kind(*values)
    )
    made.register_unstructure_hook_func(_is_array, _packed)
    made.register_structure_hook_func(_is_array, lambda value, _: _unpacked(value))
    apart: dict[str, Any] = dict.fromkeys(
        ("convergence", "costs", "extras", "analyses"), STORED_SEPARATELY
    )
    made.register_unstructure_hook(Study, make_dict_unstructure_fn(Study, made, **apart))
    made.register_structure_hook(Study, make_dict_structure_fn(Study, made, **apart))

    def with_kinds(result: TaskResult) -> dict[str, Any]:
        parts = {"answer": result.answer, "request": result.request}
        kinds = {name: _name(type(part)) for name, part in parts.items() if part is not None}
        plain_parts = {name: made.unstructure(part) for name, part in vars(result).items()}
        return {**plain_parts, "kinds": kinds}

    def of_kinds(held: Mapping[str, Any], _: type[TaskResult]) -> TaskResult:
        names = held["kinds"].items()
        parts = {part: made.structure(held[part], stored_class(name)) for part, name in names}
        texts: dict[str, Any] = {
            name: made.structure(held[name], str) for name in ("scene", "label", "lost")
        }
        result = TaskResult(**parts, **texts)
        if result.request and not isinstance(result.answer, (result.request.kind(), NoneType)):
            raise TypeError(f"a {type(result.answer).__name__} answers {result.request}")
        return result

    made.register_unstructure_hook(TaskResult, with_kinds)
    made.register_structure_hook(TaskResult, of_kinds)
    return made


def _as_declared(value: Any, kind: type[StoredItem]) -> StoredItem:
    """Returns the value if it is of this kind; raises TypeError otherwise."""
    if type(value) is not kind:
        raise TypeError(f"{shortened(repr(value))} is no {kind.__name__}")
    return value


def _name(kind: type[Any]) -> str:
    """The name by which a class is stored; raises KeyError if it has none."""
    names = {place: name for name, place in KINDS.items()}
    return names[f"{kind.__module__}.{kind.__name__}".removeprefix(ENGINES)]


def stored_class(name: str) -> type[Any]:
    """The class that is stored under this name, whose module is imported."""
    module, _, own = KINDS[name.rpartition(".")[2]].rpartition(".")
    kind: type[Any] = getattr(import_module(ENGINES + module), own)
    return kind


def _is_array(kind: Any) -> bool:
    return kind is np.ndarray or get_origin(kind) is np.ndarray


def _packed(array: Array) -> tuple[tuple[int, ...], str]:
    """The shape of an array, and its numbers as compressed bytes in base64."""
    held = zlib.compress(np.asarray(array, DOUBLES).tobytes())
    return np.shape(array), base64.b64encode(held).decode()


def _unpacked(packed: tuple[tuple[int, ...], str]) -> Array:
    shape, text = packed
    held = zlib.decompress(base64.b64decode(text))
    return np.frombuffer(bytearray(held), DOUBLES).reshape(shape)


def hashable(value: Any) -> Any:
    """A JSON value with tuples in place of lists."""
    if isinstance(value, dict):
        return {name: hashable(entry) for name, entry in value.items()}
    return tuple(map(hashable, value)) if isinstance(value, (list, tuple)) else value
