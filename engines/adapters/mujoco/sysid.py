"""A fit by MuJoCo's own system identification: its parameters, bounds and least squares."""

from __future__ import annotations

import importlib
import io
from collections.abc import Callable
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.method import Unsupported


def fit(residuals: Callable[[Array], Array], start: Array) -> Array:
    """The place, shape (p,), in the unit box, with the least sum of squares of `residuals`, shape
    (m,), from a `start` on; raises Unsupported."""
    sysid: Any = importlib.import_module("mujoco.sysid")
    if not hasattr(sysid, "optimize"):
        raise Unsupported("mujoco.sysid lacks packages: pip install 'mujoco[sysid]'")

    def every(places: Array, parameters: Any) -> tuple[list[Array], None, None]:
        columns = np.reshape(places, (start.size, -1)).T
        return [np.stack([residuals(place) for place in columns], axis=1)], None, None

    parameters = sysid.ParameterDict()
    parameters.add(sysid.Parameter("place", start, np.zeros_like(start), np.ones_like(start)))
    fitted, _ = sysid.optimize(parameters, every, verbose=False, output=io.StringIO())
    return np.asarray(fitted.as_vector(), dtype=float)
