"""The figures of a contact audit's answer that its template needs beside the audit itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from plumbob.engines.audit.contacts import HEADINGS, PUSH, ContactAudit, Measured

INSIDE = 2e-4  # relative: a smaller part of a distance is not worth a digit
APART = 0.01  # relative: errors that differ by more between headings are shown


@dataclass(frozen=True)
class Errors:
    """Errors of stopping distances over all headings."""

    known: bool  # whether any distance can be compared
    stuck: tuple[float, ...]  # [°]: headings at which the body does not stop
    worst: float = math.nan  # [m]
    heading: float = math.nan  # [°] of the worst
    per_cent: float | None = None  # of the distance
    least: float | None = None  # of all headings, as that
    most: float | None = None
    varies: bool = False


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

    @property
    def errors(self) -> Errors:
        """Of the distances at the own step."""
        errors, distances = self.audit.errors(self.run), self.audit.distances
        degrees = np.degrees(HEADINGS)
        if np.isnan(errors).all():
            return Errors(False, ())
        if (stuck := np.isinf(errors)).any():
            return Errors(True, tuple(degrees[stuck]))
        k = int(np.nanargmax(np.abs(errors)))
        least = float(np.nanmin(errors / distances))
        most = float(np.nanmax(errors / distances))
        return Errors(
            True,
            (),
            abs(float(errors[k])),
            float(degrees[k]),
            per_cent(float(errors[k]), float(distances[k])),
            per_cent(least, 1.0),
            per_cent(most, 1.0),
            most - least > APART,
        )

    @property
    def dependence(self) -> float | None:
        """Differences of distances between headings [%]."""
        value = 100 * self.audit.dependence(self.run)
        return value if math.isfinite(value) else None

    @property
    def drifts(self) -> bool:
        """Whether the speed at which it drifts is known."""
        return self.run.drift is not None and math.isfinite(self.run.drift)

    @property
    def turned(self) -> float:
        """By how much the body turned when it slid straight on [°]."""
        return math.degrees(self.run.turned)

    @property
    def turn(self) -> float | None:
        """The turn of the body that turns too [°]; None where it does not stop."""
        turning = self.run.turning
        return math.degrees(turning.turn) if turning and turning.rests else None

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
        return float((self.halving[-1] / self.halving[0]) ** (1 / (len(self.halving) - 1)))


@dataclass(frozen=True)
class Contacts:
    """A contact audit, and what follows from it."""

    audit: ContactAudit
    push: float = PUSH
    headings: tuple[float, ...] = tuple(math.degrees(heading) for heading in HEADINGS)

    @property
    def kinds(self) -> tuple[Kind, Kind]:
        """The model's own contacts, and the pasted ones."""
        audit = self.audit
        return Kind("your contacts", audit, audit.own), Kind("pasted contacts", audit, audit.pasted)

    @property
    def friction(self) -> tuple[float, ...]:
        """The coefficient of all points, or the least and the largest."""
        body = self.audit.standing
        least, most = min(body.friction), max(body.friction)
        return (least, most) if math.isnan(body.coefficient) else (least,)

    @property
    def judged(self) -> int:
        """Headings at which Coulomb's law determines the distance."""
        return sum(self.audit.determined)

    @property
    def tends(self) -> tuple[float, float] | None:
        """The least and the largest distance [m] to compare with; None where none is known."""
        distances = self.audit.distances[~np.isnan(self.audit.distances)]
        return (float(distances.min()), float(distances.max())) if distances.size else None

    @property
    def predictable(self) -> bool:
        """Whether theory has errors of the pasted contacts."""
        return self.audit.predicted(self.audit.pasted[0]) is not None

    @property
    def predicted(self) -> float | None:
        """That of the worst heading [%]; None where a load gets to 0."""
        pasted, exact = self.audit.pasted[0], self.audit.exact
        predicted = self.audit.predicted(pasted)
        if predicted is None or exact is None:
            return None
        return per_cent(
            float(predicted[int(np.nanargmax(np.abs(self.audit.errors(pasted))))]), exact
        )

    @property
    def turn(self) -> float | None:
        """The turn to compare with [°]; None where none is known."""
        return _degrees(self.audit.turn)

    @property
    def turn_known(self) -> float | None:
        """To how much it is [°]."""
        return _degrees(self.audit.turn_known)


def _degrees(angle: float) -> float | None:
    return math.degrees(angle) if math.isfinite(angle) else None


def per_cent(error: float, distance: float) -> float | None:
    """A signed error relative to a distance [%]; None where it does not stop."""
    if not math.isfinite(error) or not distance:
        return None
    return 100 * error / distance if abs(error / distance) >= INSIDE else 0.0
