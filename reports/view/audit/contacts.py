"""A contact audit as text: how far the body slides, and what other friction settings change."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from plumbob.engines.audit.contacts import HEADINGS, PUSH, ContactAudit, Measured
from plumbob.reports.view.audit.text import aligned, duration, length

SHOWN = 4  # feet by name
HELPS, HARDLY = 0.71, 0.95  # ratio of errors a halving: below the first it helps
INSIDE = 2e-4  # relative: a smaller part of a distance is not worth a digit


def contact_lines(audit: ContactAudit) -> list[str]:
    """The answer as lines of text."""
    return aligned(contact_rows(audit))


def contact_rows(audit: ContactAudit) -> list[tuple[str, str]]:
    """The answer: names of the lines, and what they say."""
    return [
        (Path(audit.name).name, _body(audit)),
        ("slide", _compared_with(audit)),
        *_errors(audit),
        ("halving", "; ".join(_halvings(audit)) or "not run"),
        ("push", _push(audit)),
        ("turn", _turn(audit)),
        ("paste", paste_command(audit)),
        *(("not run", reason) for reason in audit.failed),
        *(("left out", "; ".join(audit.notes)) for _ in audit.notes[:1]),
        ("not claimed", "joints that move, other speeds, starts that tip; reality"),
    ]


def paste_command(audit: ContactAudit) -> str:
    """The command that prints the settings."""
    friction = f"{audit.standing.friction[0]:g}"
    return (
        f"plumbob settings {audit.method} --step {audit.step:g} --friction {friction} "
        f"--stiffness {audit.stiffness:g}"
    )


def per_cent(error: float, distance: float) -> str:
    """A signed error relative to a distance."""
    if not math.isfinite(error) or not distance:
        return "it does not stop"
    relative = error / distance
    return f"{100 * relative:+.2g} %" if abs(relative) >= INSIDE else "0 %"


def _body(audit: ContactAudit) -> str:
    body = audit.standing
    feet = ", ".join(body.feet[:SHOWN])
    if len(body.feet) > SHOWN:
        feet += f" and {len(body.feet) - SHOWN} more"
    least, most = min(body.friction), max(body.friction)
    friction = f"{least:g}" if most - least <= 1e-9 * most else f"{least:g} … {most:g}"
    locked = f", {body.locked} joints locked as they start" if body.locked else ""
    return (
        f"{body.body}: {body.mass:.3g} kg on {len(body.points)} points ({feet}) of {body.plane}, "
        f"friction {friction}{locked}; {audit.integrator} {duration(audit.step)}"
    )


def _compared_with(audit: ContactAudit) -> str:
    start = f"from {audit.speed:g} m/s at {len(HEADINGS)} headings"
    if audit.exact is not None:
        some = sum(audit.determined)
        loads = "every load stays above 0"
        if some < len(HEADINGS):
            loads += f" at {some} of them, and only these are judged"
        return f"{start}; Coulomb: it stops after {length(audit.exact)}, at any heading; {loads}"
    distances = audit.distances[~np.isnan(audit.distances)]
    if not any(audit.determined):
        most = audit.steadiest
        return f"{start}; not determined: {audit.why}; give --friction {most:g} or less"
    if not distances.size:
        return f"{start}; no distance to compare with: {audit.why}"
    values = f"{length(float(distances.min()))} … {length(float(distances.max()))}"
    known = length(audit.known)
    return f"{start}; not determined: {audit.why}; the pasted contacts tend to {values} (± {known})"


def _errors(audit: ContactAudit) -> Iterator[tuple[str, str]]:
    if audit.own:
        default, more = audit.own[0], ""
        if audit.exact is not None:
            more = f"; distances differ by {_fraction(audit.dependence(default))} between headings"
        turned = math.degrees(default.turned)
        more += f"; turns by up to {turned:.2g}°, where none is due" if turned > 0.1 else ""
        yield "your contacts", _range(audit, default) + more
    if audit.pasted:
        pasted = audit.pasted[0]
        predicted, more = audit.predicted(pasted), ""
        if predicted is not None and audit.exact is not None:
            k = int(np.nanargmax(np.abs(audit.errors(pasted))))
            value = float(predicted[k])
            more = f"; predicted {per_cent(value, audit.exact)}"
            if math.isnan(value):
                more = "; not predicted: a load gets to 0 for a while"
            more += f"; distances differ by {_fraction(audit.dependence(pasted))}"
        yield "pasted", _range(audit, pasted) + more


def _range(audit: ContactAudit, run: Measured) -> str:
    errors = audit.errors(run)
    if np.isnan(errors).all():
        return "no distance to compare with"
    if np.isinf(errors).any():
        at = np.degrees(HEADINGS)[np.isinf(errors)]
        return f"it does not stop at {', '.join(f'{angle:.0f}°' for angle in at)}"
    k = int(np.nanargmax(np.abs(errors)))
    worst, distance = float(errors[k]), float(audit.distances[k])
    least = float(np.nanmin(errors / audit.distances))
    most = float(np.nanmax(errors / audit.distances))
    between = f", {per_cent(least, 1.0)} to {per_cent(most, 1.0)}" if most - least > 0.01 else ""
    where = f" at {math.degrees(HEADINGS[k]):.0f}°" if between else ""
    return f"error {length(abs(worst))} ({per_cent(worst, distance)}){where}{between}"


def _fraction(value: float) -> str:
    return f"{100 * value:.2g} %" if math.isfinite(value) else "more than can be said"


def _halvings(audit: ContactAudit) -> Iterator[str]:
    for name, runs in (("own", audit.own), ("pasted", audit.pasted)):
        errors = [audit.error(run) for run in runs]
        if name == "pasted" and audit.exact is None:
            errors = errors[:-1]  # what is compared with the finest
        if len(errors) < 2 or not np.isfinite(errors).all() or not errors[0]:
            continue
        ratio = (errors[-1] / errors[0]) ** (1 / (len(errors) - 1))
        helps = "helps" if ratio < HELPS else "hardly helps" if ratio < HARDLY else "does not help"
        yield f"{name}: {' -> '.join(map(length, errors))}: {helps}"


def _push(audit: ContactAudit) -> str:
    parts = [
        f"{name} {_speed(runs[0].drift)}"
        for name, runs in (("your contacts drift at", audit.own), ("pasted", audit.pasted))
        if runs and runs[0].drift is not None
    ]
    if not parts:
        return f"none: at {PUSH:g} of the friction limit it tips"
    return f"at {PUSH:g} of the friction limit: {', '.join(parts)}; Coulomb: 0"


def _speed(value: float) -> str:
    return "no known speed" if not math.isfinite(value) else f"{length(value)}/s"


def _turn(audit: ContactAudit) -> str:
    def angle(runs: Sequence[Measured]) -> str:
        turning = runs[0].turning if runs else None
        if turning is None:
            return "not run"
        return f"{math.degrees(turning.turn):.3g}°" if turning.rests else "it does not stop"

    start = f"sliding at {audit.spin:.3g} rad/s too: your contacts {angle(audit.own)}, "
    start += f"pasted {angle(audit.pasted)}"
    if audit.exact_turn is not None:
        return f"{start}; Coulomb: {math.degrees(audit.exact_turn):.3g}°"
    known = math.isfinite(audit.turn)
    doubt = f" (± {math.degrees(audit.turn_known):.2g}°)" if math.isfinite(audit.turn_known) else ""
    tends = f"pasted tend to {math.degrees(audit.turn):.3g}°{doubt}; " if known else ""
    return f"{start}; {tends}not determined: {audit.why_turn}"
