"""Numbers and records as plain data: mappings, sequences, numbers and texts."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np


@dataclass(frozen=True)
class PlainForm:
    """How values are written as plain data."""

    sequence: Callable[[Iterable[Any]], Any]  # type of the sequences
    properties: bool  # whether a dataclass is written with its properties
    finite: bool  # whether a number that is not finite becomes None


FOR_TEMPLATES = PlainForm(tuple, properties=True, finite=False)  # and for the store
FOR_JSON = PlainForm(list, properties=False, finite=True)


def plain(value: Any, form: PlainForm) -> Any:
    """Returns a value as plain data: a record, a dataclass or a mapping becomes a mapping by name,
    an array becomes nested sequences."""
    if isinstance(value, SimpleNamespace):
        value = vars(value)
    if is_dataclass(value) and not isinstance(value, type):
        names = [field.name for field in fields(value)]
        if form.properties:
            members = vars(type(value)).items()
            names += [name for name, member in members if isinstance(member, property)]
        return {name: plain(getattr(value, name), form) for name in names}
    if isinstance(value, Mapping):
        return {str(name): plain(entry, form) for name, entry in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), form)
    if isinstance(value, Iterable) and not isinstance(value, (str, bytes)):
        return form.sequence(plain(entry, form) for entry in value)
    number = value.item() if isinstance(value, np.generic) else value
    is_lost = form.finite and isinstance(number, float) and not math.isfinite(number)
    return None if is_lost else number


def json_text(value: Any) -> str:
    """Returns a value as JSON text, as commands print it with --json."""
    return json.dumps(plain(value, FOR_JSON), indent=1)
