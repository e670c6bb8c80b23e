"""Changes between two audits of a model, read from their JSON."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

Stored = Mapping[str, Any]
"""An audit as its JSON data."""
SETTINGS = (
    "integrator",
    "step",
    "start",
    "control",
    "control_period",
    "duration",
    "worst_body",
)
ABSENT = "none"
# Measure of errors of older audits, which do not name one
CENTRES = "distance of centres of mass"
# Chosen, relative and [m, s, m/s]: a run repeats to the bit, and JSON keeps doubles exactly.
# Rounding on another processor is far below a nanometre, and the effect of an edit above it.
ROUNDING = 1e-9
MOST = 12  # most numbers of a state that are written out


@dataclass(frozen=True)
class AuditChange:
    """A difference of an audit from an older audit."""

    what: str
    old: str
    new: str
    growth: float | None = None
    """Increase relative to the old error; infinite if something is lost; None if the change is
    neither better nor worse."""


def audited_file(audit: Stored) -> str:
    """Returns the path of the model file of a stored audit, or the name of the model."""
    return str(audit.get("path", audit.get("model", "")))


def changes(old: Stored, new: Stored) -> tuple[AuditChange, ...]:
    """Returns everything that distinguishes two audits, given as their JSON data. An error that no
    longer has a value counts as infinite. An error below the uncertainties of the references counts
    as none."""
    if "fields" not in old:
        return (AuditChange("audit", f"none: {old['why']}", "there is one"),)
    old_settings = _settings(old)
    new_settings = _settings(new)
    if not _measured_alike(old, new):
        new_settings["worst_body"] = old_settings["worst_body"]
    return (
        *_error_changes(old, new),
        *(
            _change(name, old_settings.get(name, ABSENT), new_settings.get(name, ABSENT))
            for name in dict.fromkeys((*old_settings, *new_settings))
            if not _equal(old_settings.get(name), new_settings.get(name))
        ),
    )


def _settings(audit: Stored) -> dict[str, Any]:
    """Returns settings, versions and the fields of an audited model."""
    return (
        {name: audit[name] for name in SETTINGS}
        | {f"version of {name}": value for name, value in audit["versions"].items()}
        | {f"field {name}": value for name, value in audit["fields"].items()}
    )


def _equal(was: Any, now: Any) -> bool:
    """Whether two values are equal up to rounding."""
    if isinstance(was, list) and isinstance(now, list):
        return len(was) == len(now) and all(map(_equal, was, now))
    if isinstance(was, float) and isinstance(now, float):
        return math.isclose(was, now, rel_tol=ROUNDING, abs_tol=ROUNDING)
    return bool(was == now)


def _change(what: str, old: Any, new: Any, growth: float | None = None) -> AuditChange:
    """Returns a difference with its values as short texts."""

    def text(value: Any) -> str:
        if isinstance(value, list):
            return " ".join(map(text, value)) if len(value) <= MOST else f"{len(value)} numbers"
        return f"{value:.6g}" if isinstance(value, float) else str(value)

    return AuditChange(what, text(old), text(new), growth)


def _measured_alike(old: Stored, new: Stored) -> bool:
    """Whether two audits measure errors in the same way."""
    return bool(_measure(old) == _measure(new))


def _measure(audit: Stored) -> Any:
    """Returns the measure of errors of an audit."""
    return audit.get("error_measure", CENTRES)


def _error_changes(old: Stored, new: Stored) -> Iterator[AuditChange]:
    """Yields changes of the error, as far as both motions are certified and measured alike, of the
    certified motion, its end, and stability."""
    ends = [audit["certified_until"] for audit in (old, new)]
    shared = min(len(audit["error_over_time"]) for audit in (old, new))
    old_error, new_error = (_error(audit, shared) for audit in (old, new))
    uncertainty = sum(audit["uncertainty"] or 0.0 for audit in (old, new))
    alike = _measured_alike(old, new)
    if not alike:
        what = "the measure of errors, which are not compared:"
        yield _change(what, _measure(old), _measure(new))
    elif all(ends) and abs(new_error - old_error) > uncertainty:
        until = "" if math.isclose(*ends) else f" at {min(ends):.3g} s"
        yield _change(
            f"error{until} [m]", old_error, new_error, _ratio(new_error, old_error) - 1.0
        )
    if not math.isclose(*ends):
        worsening = math.inf if alike and ends[1] < ends[0] else None
        yield _change("certified until [s]", ends[0], ends[1], worsening)
    elif ends[0]:
        displacements = _displacements(old, new)
        furthest = max(sorted(displacements), key=lambda body: displacements[body], default="")
        distance = displacements.get(furthest, 0.0)
        if distance > uncertainty:
            what = f"certified {furthest} at {ends[0]:.3g} s by [m]"
            yield _change(what, 0.0, distance, _ratio(distance, old_error))
    if old["unstable"] != new["unstable"]:
        worsening = math.inf if new["unstable"] else None
        yield _change("unstable", old["unstable"], new["unstable"], worsening)


def _displacements(old: Stored, new: Stored) -> dict[str, float]:
    """Returns {body: displacement [m]} for the bodies that both audits have. It is the displacement
    of the corner that has moved furthest, or of the centre of mass if the audits have different
    numbers of corners."""
    displacements = dict[str, float]()
    for body in old["pose"].keys() & new["pose"].keys():
        centres = [[audit["pose"][body]] for audit in (old, new)]
        corners = [audit.get("corners", {}).get(body, []) for audit in (old, new)]
        for before, now in (centres, corners):
            if now and list(map(len, before)) == list(map(len, now)):
                displacements[body] = max(map(math.dist, before, now))
    return displacements


def _error(audit: Stored, samples: int) -> float:
    """Returns the largest error [m] over the first `samples` control periods."""
    error = audit["error_over_time"][samples - 1] if samples else audit["error"]
    return math.inf if error is None else float(error)


def _ratio(size: float, error: float) -> float:
    """Returns a size relative to an error; infinite if the error is 0."""
    return size / error if error else math.inf
