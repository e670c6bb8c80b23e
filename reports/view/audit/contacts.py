"""The figures of a contact audit's answer that its template needs beside the audit itself."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.engines.audit.contacts import HEADINGS, PUSH, ContactAudit, Measured
from plumbob.reports.view.audit.motion import mean_ratio

DEGREES = tuple(math.degrees(heading) for heading in HEADINGS)


@dataclass(frozen=True)
class Kind:
    """Runs of the body on contacts of one kind, coarse to fine."""

    name: str
    audit: ContactAudit
    runs: tuple[Measured, ...]

    @property
    def run(self) -> Measured:
        """That at the own step."""
        return self.runs[0]

    @cached_property
    def errors(self) -> Array:
        """Of the distances at the own step [m], by heading."""
        return self.audit.errors(self.run)

    @property
    def stuck(self) -> tuple[float, ...]:
        """Headings at which the body does not stop [°]."""
        return tuple(np.degrees(HEADINGS)[np.isinf(self.errors)])

    @property
    def worst(self) -> int:
        """The heading with the largest error; -1 where none is known."""
        errors = np.abs(self.errors)
        return -1 if np.isnan(errors).all() else int(np.nanargmax(errors))

    @property
    def per_cents(self) -> Array:
        """The errors over the distances [%], by heading, those that are not known left out."""
        relative = 100 * self.errors / self.audit.distances
        return np.asarray(relative[~np.isnan(relative)])

    @property
    def per_cent(self) -> float:
        """The largest of them."""
        return float(max(self.per_cents.tolist(), key=abs))

    @property
    def predicted(self) -> float | None:
        """That of the worst heading [%] by theory, where it has one; not a number where a load gets
        to 0."""
        predicted, exact = self.audit.predicted(self.run), self.audit.exact
        return None if predicted is None or not exact else 100 * predicted[self.worst] / exact

    @property
    def turn(self) -> float | None:
        """The turn of the body that turns too [rad]; None where it does not stop."""
        turning = self.run.turning
        return turning.turn if turning and turning.rests else None

    @property
    def halving(self) -> tuple[float, ...]:
        """The largest error [m] at each step that is compared; none where one is not known."""
        errors = [self.audit.error(run) for run in self.runs]
        if self.runs is self.audit.pasted and self.audit.exact is None:
            errors = errors[:-1]  # the finest is what is compared with
        known = len(errors) > 1 and np.isfinite(errors).all() and errors[0]
        return tuple(errors) if known else ()

    @property
    def ratio(self) -> float:
        """Of the errors of a step and of its half, on average."""
        return mean_ratio(self.halving)


def answer_of(audit: ContactAudit) -> dict[str, Any]:
    """A contact audit, and what follows from it: runs on the model's own contacts and on the pasted
    ones, and the distances [m] to compare with, from the least on, none where none is known."""
    known = audit.distances[~np.isnan(audit.distances)]
    return {
        "kinds": (
            Kind("your contacts", audit, audit.own),
            Kind("pasted contacts", audit, audit.pasted),
        ),
        "tends": sorted(known.tolist()),
        "push": PUSH,
        "headings": DEGREES,
        "degree": math.degrees(1.0),
    }
