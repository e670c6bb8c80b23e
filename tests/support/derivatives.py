"""The scale that an error of a derivative is compared with."""

from __future__ import annotations

import numpy as np

from plumbob.analytic.reference import Array


def scaled(values: Array, observed: Array, number: float) -> float:
    """Its own size, or the observable's over the parameter's, the larger."""
    largest = max(float(np.abs(values).max()), float(np.abs(observed).max() / (abs(number) or 1)))
    return largest or 1.0
