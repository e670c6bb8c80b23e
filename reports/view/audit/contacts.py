"""A contact audit as text: how far the body slides, and what other friction settings change."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from plumbob.analytic.systems.sliding_body import Stance
from plumbob.engines.audit.contacts import HEADINGS, PUSH, ContactAudit, Measured
from plumbob.reports.view.audit.text import aligned, duration, length

SHOWN = 4  # feet by name
HELPS, HARDLY = 0.71, 0.95  # ratio of errors a halving: below the first it helps
INSIDE = 2e-4  # relative: a smaller part of a distance is not worth a digit


def contact_lines(found: ContactAudit) -> list[str]:
    """The answer as lines of text."""
    return aligned(contact_rows(found))


def contact_rows(found: ContactAudit) -> list[tuple[str, str]]:
    """The answer: names of the lines, and what they say."""
    return [
        (Path(found.name).name, _body(found)),
        ("slide", _compared_with(found)),
        *_errors(found),
        ("halving", "; ".join(_halvings(found)) or "not run"),
        ("push", _push(found)),
        ("turn", _turn(found)),
        ("paste", paste_command(found)),
        *(("not run", reason) for reason in found.failed),
        *(("left out", "; ".join(found.notes)) for _ in found.notes[:1]),
        ("not claimed", "joints that move, other speeds, starts that tip; reality"),
    ]


def paste_command(found: ContactAudit) -> str:
    """The command that prints the settings."""
    friction = f"{found.standing.friction[0]:g}"
    return (
        f"plumbob settings {found.method} --step {found.step:g} --friction {friction} "
        f"--stiffness {found.stiffness:g}"
    )


def steadiest(found: ContactAudit) -> float:
    """The largest friction coefficient, in two digits, at which it slides along any heading with
    every load above 0."""
    body = found.standing
    most = Stance(body.points, body.height).inside(np.zeros(2)) / body.height
    digits = 10.0 ** (math.floor(math.log10(most)) - 1)
    return math.floor(most / digits) * digits


def per_cent(error: float, distance: float) -> str:
    """A signed error relative to a distance."""
    if not math.isfinite(error) or not distance:
        return "it does not stop"
    relative = error / distance
    return f"{100 * relative:+.2g} %" if abs(relative) >= INSIDE else "0 %"


def _body(found: ContactAudit) -> str:
    body = found.standing
    feet = ", ".join(body.feet[:SHOWN])
    if len(body.feet) > SHOWN:
        feet += f" and {len(body.feet) - SHOWN} more"
    least, most = min(body.friction), max(body.friction)
    friction = f"{least:g}" if most - least <= 1e-9 * most else f"{least:g} … {most:g}"
    locked = f", {body.locked} joints locked as they start" if body.locked else ""
    return (
        f"{body.body}: {body.mass:.3g} kg on {len(body.points)} points ({feet}) of {body.plane}, "
        f"friction {friction}{locked}; {found.integrator} {duration(found.step)}"
    )


def _compared_with(found: ContactAudit) -> str:
    start = f"from {found.speed:g} m/s at {len(HEADINGS)} headings"
    if found.exact is not None:
        some = sum(found.determined)
        loads = "every load stays above 0"
        if some < len(HEADINGS):
            loads += f" at {some} of them, and only these are judged"
        return f"{start}; Coulomb: it stops after {length(found.exact)}, at any heading; {loads}"
    distances = found.distances[~np.isnan(found.distances)]
    if not any(found.determined):
        most = steadiest(found)
        return f"{start}; not determined: {found.why}; give --friction {most:g} or less"
    if not distances.size:
        return f"{start}; no distance to compare with: {found.why}"
    values = f"{length(float(distances.min()))} … {length(float(distances.max()))}"
    known = length(found.known)
    return f"{start}; not determined: {found.why}; the pasted contacts tend to {values} (± {known})"


def _errors(found: ContactAudit) -> Iterator[tuple[str, str]]:
    if found.own:
        own, more = found.own[0], ""
        if found.exact is not None:
            more = f"; distances differ by {_fraction(found.dependence(own))} between headings"
        turned = math.degrees(own.turned)
        more += f"; turns by up to {turned:.2g}°, where none is due" if turned > 0.1 else ""
        yield "your contacts", _range(found, own) + more
    if found.pasted:
        pasted = found.pasted[0]
        predicted, more = found.predicted(pasted), ""
        if predicted is not None and found.exact is not None:
            k = int(np.nanargmax(np.abs(found.errors(pasted))))
            value = float(predicted[k])
            more = f"; predicted {per_cent(value, found.exact)}"
            if math.isnan(value):
                more = "; not predicted: a load gets to 0 for a while"
            more += f"; distances differ by {_fraction(found.dependence(pasted))}"
        yield "pasted", _range(found, pasted) + more


def _range(found: ContactAudit, one: Measured) -> str:
    errors = found.errors(one)
    if np.isnan(errors).all():
        return "no distance to compare with"
    if np.isinf(errors).any():
        at = np.degrees(HEADINGS)[np.isinf(errors)]
        return f"it does not stop at {', '.join(f'{angle:.0f}°' for angle in at)}"
    k = int(np.nanargmax(np.abs(errors)))
    worst, distance = float(errors[k]), float(found.distances[k])
    least = float(np.nanmin(errors / found.distances))
    most = float(np.nanmax(errors / found.distances))
    between = f", {per_cent(least, 1.0)} to {per_cent(most, 1.0)}" if most - least > 0.01 else ""
    where = f" at {math.degrees(HEADINGS[k]):.0f}°" if between else ""
    return f"error {length(abs(worst))} ({per_cent(worst, distance)}){where}{between}"


def _fraction(value: float) -> str:
    return f"{100 * value:.2g} %" if math.isfinite(value) else "more than can be said"


def _halvings(found: ContactAudit) -> Iterator[str]:
    for name, runs in (("own", found.own), ("pasted", found.pasted)):
        errors = [found.error(one) for one in runs]
        if name == "pasted" and found.exact is None:
            errors = errors[:-1]  # what is compared with the finest
        if len(errors) < 2 or not np.isfinite(errors).all() or not errors[0]:
            continue
        ratio = (errors[-1] / errors[0]) ** (1 / (len(errors) - 1))
        helps = "helps" if ratio < HELPS else "hardly helps" if ratio < HARDLY else "does not help"
        yield f"{name}: {' -> '.join(map(length, errors))}: {helps}"


def _push(found: ContactAudit) -> str:
    parts = [
        f"{name} {_speed(runs[0].drift)}"
        for name, runs in (("your contacts drift at", found.own), ("pasted", found.pasted))
        if runs and runs[0].drift is not None
    ]
    if not parts:
        return f"none: at {PUSH:g} of the friction limit it tips"
    return f"at {PUSH:g} of the friction limit: {', '.join(parts)}; Coulomb: 0"


def _speed(value: float) -> str:
    return "no known speed" if not math.isfinite(value) else f"{length(value)}/s"


def _turn(found: ContactAudit) -> str:
    def angle(runs: Sequence[Measured]) -> str:
        one = runs[0].turning if runs else None
        if one is None:
            return "not run"
        return f"{math.degrees(one.turn):.3g}°" if one.rests else "it does not stop"

    start = f"sliding at {found.spin:.3g} rad/s too: your contacts {angle(found.own)}, "
    start += f"pasted {angle(found.pasted)}"
    if found.exact_turn is not None:
        return f"{start}; Coulomb: {math.degrees(found.exact_turn):.3g}°"
    known = math.isfinite(found.turn)
    doubt = f" (± {math.degrees(found.turn_known):.2g}°)" if math.isfinite(found.turn_known) else ""
    tends = f"pasted tend to {math.degrees(found.turn):.3g}°{doubt}; " if known else ""
    return f"{start}; {tends}not determined: {found.why_turn}"
