"""Dataclasses as JSON and back, every float to the last bit, and recordings as compressed bytes."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import MappingProxyType
from typing import Any, TypeVar

import cattrs
import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.trajectory import Trajectory

T = TypeVar("T")
# What readers raise, beside ValueError, for a text or bytes of another shape than expected.
DAMAGE = (
    TypeError, KeyError, AttributeError, IndexError, OverflowError, RecursionError, zlib.error,
    cattrs.StructureHandlerNotFoundError,
)  # fmt: skip
PARTS = ("observables", "channels")  # of a recording: mappings of arrays
DOUBLES = np.dtype("<f8")


def to_json(item: Any) -> str:
    """A dataclass, or what JSON knows, as JSON; a float as the shortest text that is that very
    float, and NaN, Infinity and -Infinity by these words."""
    return json.dumps(_converter().unstructure(item))


def from_json(text: str, kind: type[T]) -> T:
    """The item of this kind that `to_json` made the text of; raises ValueError where it is none."""
    try:
        return _converter().structure(json.loads(text), kind)
    except cattrs.BaseValidationError as error:
        raise ValueError(f"no {kind.__name__}: {error.exceptions[0]}") from None
    except DAMAGE as error:
        raise ValueError(f"no {kind.__name__}: {error}") from None


def packed(run: Trajectory) -> tuple[str, bytes]:
    """A recording as JSON of what is a number of its own, with the shapes of its arrays, and these
    one after the other as compressed bytes."""
    arrays = {f"{part}/{n}": a for part in PARTS for n, a in getattr(run, part).items()}
    arrays["times"] = run.times
    single = {name: getattr(run, name) for name in ("steps", "seconds", "diverged_at", "warnings")}
    single["arrays"] = {name: np.shape(array) for name, array in arrays.items()}
    held = b"".join(np.asarray(array, DOUBLES).tobytes() for array in arrays.values())
    return to_json(single), zlib.compress(held)


def unpacked(text: str, arrays: bytes) -> Trajectory:
    """The recording that `packed` made these of; raises ValueError where it is none."""
    try:
        return _unpacked(text, arrays)
    except DAMAGE as error:
        raise ValueError(f"no recording: {error}") from None


def _unpacked(text: str, arrays: bytes) -> Trajectory:
    single = json.loads(text)
    shapes = single.pop("arrays")
    ends = np.cumsum([math.prod(shape) for shape in shapes.values()])
    pieces = np.split(np.frombuffer(bytearray(zlib.decompress(arrays)), DOUBLES), ends)
    if len(pieces.pop()):
        raise ValueError("no recording: more numbers than its arrays have")
    parts: dict[str, dict[str, Array]] = {part: {} for part in PARTS}
    for (key, shape), piece in zip(shapes.items(), pieces, strict=True):
        part, _, name = key.partition("/")
        parts.setdefault(part, {})[name] = piece.reshape(shape)
    blank = Trajectory(parts["times"][""], parts["observables"], parts["channels"])
    return replace(blank, **{**single, "warnings": tuple(single["warnings"])})


@cache
def _converter() -> cattrs.Converter:
    """What cattrs does by itself, and: read-only mappings are mappings, numbers of numpy numbers,
    and lists where any value may stand tuples, which can be hashed."""
    made = cattrs.Converter()
    made.register_unstructure_hook(MappingProxyType, lambda m: made.unstructure(dict(m)))
    made.register_unstructure_hook(np.generic, lambda value: value.item())
    made.register_structure_hook_func(lambda kind: kind is Any, lambda value, _: _hashable(value))
    return made


def _hashable(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _hashable(entry) for name, entry in value.items()}
    return tuple(map(_hashable, value)) if isinstance(value, list) else value
