"""An exact motion from a start that a double cannot hold, for engines, which start beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array, Reference


@dataclass(frozen=True)
class RoundedStart:
    """The `exact` motion, and the one `started` from its start rounded to double, which is where an
    engine starts; a `Reference`."""

    exact: Any  # a `Reference`, with whatever else it knows of itself
    started: Reference

    @property
    def closed_form(self) -> Any:
        """The exact motion's closed form; None where there is none."""
        return self.exact.closed_form

    def observe(self, times: Array) -> Mapping[str, Array]:
        """Observables of the exact motion at `times` [s], shape (n,)."""
        seen: Mapping[str, Array] = self.exact.observe(times)
        return seen

    def uncertainty(self, times: Array) -> Mapping[str, Array]:
        """What double precision allows a motion that starts and goes on in doubles: all that it
        allows the rounded start's, and how far the two motions are apart, shape (n,)."""
        seen, beside = self.exact.observe(times), self.started.observe(times)
        return {
            name: doubt + np.abs(beside[name] - seen[name])
            for name, doubt in self.started.uncertainty(times).items()
        }

    def nonlinearity(self, times: Array, errors: Mapping[str, Array]) -> float:
        """How far errors leave their linear response on the exact motion."""
        return float(self.exact.nonlinearity(times, errors))
