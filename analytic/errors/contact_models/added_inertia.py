"""Errors from inertia that an engine adds: a pendulum's bob of moment of inertia I, meant to be a
point, is like a mass m l^2 that is larger by I."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from plumbob.analytic.numerics.arithmetic import ROUNDOFF

POINTS = 200  # samples of a pendulum's motion


@lru_cache(maxsize=64)  # the same for every method and step of a scene
def bob_error(problem: Any, duration: float, moment_ratio: float) -> Mapping[str, float]:
    """Bounds on the observables of a SimplePendulum over `duration` [s] whose bob's moment of
    inertia is `moment_ratio` of m l^2: at most the effect of as many units in the last place of
    every parameter as it has."""
    doubts = problem.motion.uncertainty(np.linspace(0.0, duration, POINTS))
    return {
        name: moment_ratio / (2 * ROUNDOFF) * float(doubt.max()) for name, doubt in doubts.items()
    }
