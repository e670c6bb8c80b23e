"""Dataclasses as JSON and back, every float to the last bit, and recordings as compressed bytes."""

from __future__ import annotations

import io
import json
import zipfile
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
    TypeError, KeyError, AttributeError, IndexError, OverflowError, RecursionError, EOFError,
    OSError, zipfile.BadZipFile, zlib.error, cattrs.StructureHandlerNotFoundError,
)  # fmt: skip
PARTS = ("observables", "channels")  # of a recording: mappings of arrays


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
    """A recording as JSON of what is a number of its own, and its arrays as compressed bytes."""
    arrays = {f"{part}/{n}": a for part in PARTS for n, a in getattr(run, part).items()}
    held = io.BytesIO()
    np.savez_compressed(held, allow_pickle=False, times=run.times, **arrays)
    single = {name: getattr(run, name) for name in ("steps", "seconds", "diverged_at", "warnings")}
    return to_json(single), held.getvalue()


def unpacked(text: str, arrays: bytes) -> Trajectory:
    """The recording that `packed` made these of; raises ValueError where it is none."""
    try:
        return _unpacked(text, arrays)
    except DAMAGE as error:
        raise ValueError(f"no recording: {error}") from None


def _unpacked(text: str, arrays: bytes) -> Trajectory:
    parts: dict[str, dict[str, Array]] = {part: {} for part in PARTS}
    with np.load(io.BytesIO(arrays), allow_pickle=False) as held:
        for key in held.files:
            part, slash, name = key.partition("/")
            if slash:
                parts[part][name] = held[key]
        blank = Trajectory(held["times"], parts["observables"], parts["channels"])
    single = json.loads(text)
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
