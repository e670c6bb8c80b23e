"""Fits parameters with MuJoCo's system identification (`mujoco.sysid`)."""

from __future__ import annotations

import importlib
import io
from collections.abc import Callable
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.method import Unsupported


def fit(residuals: Callable[[Array], Array], start: Array) -> Array:
    """The place in the unit box, shape (p,), with the smallest sum of squares of `residuals`, a
    function from a place to numbers of shape (m,), found from a `start`. Raises Unsupported."""
    sysid: Any = importlib.import_module("mujoco.sysid")
    if not hasattr(sysid, "optimize"):
        raise Unsupported("mujoco.sysid lacks packages: pip install 'mujoco[sysid]'")

    def every(places: Array, parameters: Any) -> tuple[list[Array], None, None]:
        """The residuals at several places, a column for each, in the form that sysid takes."""
        columns = np.reshape(places, (start.size, -1)).T
        return [np.stack([residuals(place) for place in columns], axis=1)], None, None

    parameters = sysid.ParameterDict()
    parameters.add(sysid.Parameter("place", start, np.zeros_like(start), np.ones_like(start)))
    fitted, _ = sysid.optimize(parameters, every, verbose=False, output=io.StringIO())
    return np.asarray(fitted.as_vector(), dtype=float)
