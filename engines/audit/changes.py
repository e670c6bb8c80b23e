"""Changes between two audits of a model, as their JSON has them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

SETTINGS = ("integrator", "step", "start", "control", "control_period", "duration", "worst_body")
OF_CONTACTS = ("integrator", "step", "speed", "distance", "not_determined", "method", "stiffness")
ABSENT = "none"
# Chosen, relative and [m, s, m/s]: a run repeats to the bit, and JSON holds its doubles whole; what
# another processor rounds is far below a nanometre, and what an edit does above
ROUNDING = 1e-9
MOST = 12  # numbers of a state that are written out


@dataclass(frozen=True)
class Moved:
    """A difference of an audit from an older one."""

    what: str
    old: str
    new: str
    growth: float | None = None
    """By how much it is worse, relative to the old error; infinite where something is lost; None
    where it is neither better nor worse."""


def changes(old: Mapping[str, Any], new: Mapping[str, Any]) -> tuple[Moved, ...]:
    """Everything that two audits, of motions or of contacts, as plain data, tell apart. An error
    that no longer has a value counts as infinite, one below what the references are known to as
    none."""
    contacts = "own" in new
    if ("own" if contacts else "fields") not in old:
        return (Moved("audit", f"none: {old.get('why')}", "there is one"),)
    was, now = (_settings(audit, OF_CONTACTS if contacts else SETTINGS) for audit in (old, new))
    return (
        *(_slid(old, new) if contacts else _worse(old, new)),
        *(
            _moved(name, was.get(name, ABSENT), now.get(name, ABSENT))
            for name in dict.fromkeys((*was, *now))
            if not _same(was.get(name), now.get(name))
        ),
    )


def _settings(audit: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """Settings of these names, the body, versions and the fields of an audited model."""
    groups = {
        f"{group} {name}": value
        for group, key in (("version of", "versions"), ("field", "fields"))
        for name, value in audit.get(key, {}).items()
    }
    settings: dict[str, Any] = {name: audit[name] for name in names} | audit.get("body", {})
    return settings | groups


def _slid(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Moved]:
    """Changes of errors and drifts of the contacts as they are and as they are pasted."""
    for kind in ("own", "pasted"):
        both = zip(_slides(old[kind]), _slides(new[kind]), strict=True)
        for what, (was, now) in zip(("error [m]", "drift [m/s]"), both, strict=True):
            if not _same(was, now) and not math.isnan(was + now):
                yield _moved(f"{what} of {kind} contacts", was, now, _relative(now, was) - 1.0)


def _slides(runs: Sequence[Mapping[str, Any]]) -> tuple[float, float]:
    """The largest error [m] at the own step, and the drift [m/s]; infinite where the body does not
    run, or stop."""
    if not runs or None in runs[0]["distances"]:
        return math.inf, math.inf
    errors = [abs(error) for error in runs[0]["errors"] if error is not None]
    return max(errors, default=math.nan), abs(runs[0]["drift"] or 0.0)


def _same(was: Any, now: Any) -> bool:
    if isinstance(was, list) and isinstance(now, list):
        return len(was) == len(now) and all(map(_same, was, now))
    if isinstance(was, float) and isinstance(now, float):
        return math.isclose(was, now, rel_tol=ROUNDING, abs_tol=ROUNDING)
    return bool(was == now)


def _moved(what: str, old: Any, new: Any, growth: float | None = None) -> Moved:
    """A difference with its values as short texts."""

    def text(value: Any) -> str:
        if isinstance(value, list):
            return " ".join(map(text, value)) if len(value) <= MOST else f"{len(value)} numbers"
        return f"{value:.6g}" if isinstance(value, float) else str(value)

    return Moved(what, text(old), text(new), growth)


def _worse(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Moved]:
    """Changes of the error, as far as both are certified, of the certified motion, its end and
    stability."""
    ends = [audit["certified_until"] for audit in (old, new)]
    shared = min(len(audit["error_over_time"]) for audit in (old, new))
    before, now = (_error(audit, shared) for audit in (old, new))
    known = sum(audit["uncertainty"] or 0.0 for audit in (old, new))
    if all(ends) and abs(now - before) > known:
        until = "" if math.isclose(*ends) else f" at {min(ends):.3g} s"
        yield _moved(f"error{until} [m]", before, now, _relative(now, before) - 1.0)
    if not math.isclose(*ends):
        lost = math.inf if ends[1] < ends[0] else None
        yield _moved("certified until [s]", ends[0], ends[1], lost)
    elif (both := old["pose"].keys() & new["pose"].keys()) and ends[0]:
        apart = {body: math.dist(old["pose"][body], new["pose"][body]) for body in both}
        furthest = max(sorted(apart), key=lambda body: apart[body])
        if (distance := apart[furthest]) > known:
            what = f"certified {furthest} at {ends[0]:.3g} s by [m]"
            yield _moved(what, 0.0, distance, _relative(distance, before))
    if old["unstable"] != new["unstable"]:
        lost = math.inf if new["unstable"] else None
        yield _moved("unstable", old["unstable"], new["unstable"], lost)


def _error(audit: Mapping[str, Any], samples: int) -> float:
    """The largest error [m] over the first `samples` of its control periods."""
    error = audit["error_over_time"][samples - 1] if samples else audit["error"]
    return math.inf if error is None else float(error)


def _relative(size: float, error: float) -> float:
    return size / error if error else math.inf
