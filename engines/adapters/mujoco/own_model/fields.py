"""The numbers of a compiled model as short texts, so that two models can be compared."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np

SHORT = 12  # most numbers of a field that are written out
KEPT = 2**33  # resolution of the digest: a relative change below 1e-10 is rounding
# Prefixes of tables that follow from other fields, and of places in the text of all names.
DERIVED = ("map", "name", "bvh", "oct")


def field_texts(model: Any) -> Mapping[str, str]:
    """Returns {field: its numbers, or its shape and a digest of many numbers} of a compiled model,
    options first."""
    fields = {f"opt.{name}": np.asarray(getattr(model.opt, name)) for name in _names(model.opt)}
    for name in _names(model):
        values = getattr(model, name)
        compared = (
            isinstance(values, np.ndarray) and values.size and not name.startswith(DERIVED)
        )
        if compared:
            fields[name] = values
    return {name: _text(values) for name, values in fields.items()}


def _names(record: Any) -> list[str]:
    """Returns the names of attributes without the tables of sparse matrices, which begin with a
    capital."""
    return [name for name in dir(record) if name[0].islower()]


def _text(values: Any) -> str:
    """Returns the numbers of a field as text, or their shape and a digest if there are more than
    SHORT."""
    if values.size <= SHORT:
        return " ".join(f"{value:.10g}" for value in values.ravel())
    if values.dtype.kind == "f":
        fractions, exponents = np.frexp(values.astype(float))
        values = np.ldexp(np.round(fractions * KEPT), exponents)
    digest = hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()[:12]
    return f"{'×'.join(map(str, values.shape))} numbers, {digest}"
