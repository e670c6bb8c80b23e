"""The numbers of a compiled model as short texts, so that two models can be held side by side."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

import numpy as np

SHORT = 12  # numbers that are written out
KEPT = 2**33  # a change of a number by less than 1e-10 of it is rounding
# Tables that follow from other fields, and places in the text of all names.
DERIVED = ("map", "name", "bvh", "oct")


def fields(model: Any) -> Mapping[str, str]:
    """{field: its numbers, or its shape and a digest of them where they are many} of a compiled
    model, its options first."""
    options = {f"opt.{n}": np.asarray(getattr(model.opt, n)) for n in _names(model.opt)}
    arrays = {n: a for n in _names(model) if isinstance(a := getattr(model, n), np.ndarray)}
    kept = {n: a for n, a in arrays.items() if a.size and not n.startswith(DERIVED)}
    return {name: _text(values) for name, values in (options | kept).items()}


def _names(of: Any) -> list[str]:
    """Attributes; sparse matrices' tables begin with a capital."""
    return [name for name in dir(of) if name[0].islower()]


def _text(values: Any) -> str:
    if values.size <= SHORT:
        return " ".join(f"{value:.10g}" for value in values.ravel())
    if values.dtype.kind == "f":
        fractions, exponents = np.frexp(values.astype(float))
        values = np.ldexp(np.round(fractions * KEPT), exponents)
    digest = hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()[:12]
    return f"{'×'.join(map(str, values.shape))} numbers, {digest}"
