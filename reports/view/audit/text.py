"""An audit in ten lines: the errors, and the settings to choose."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import MappingProxyType

from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.costs import Ratio
from plumbob.engines.audit.ensemble import FINER, MEANS, STANDS_OUT, Likely
from plumbob.engines.audit.reference import OUT_OF_TIME, RESOLVED
from plumbob.engines.audit.steps import (
    TARGETS,
    Balance,
    Cheapest,
    Compared,
    horizon,
)
from plumbob.engines.audit.trims import Trim, Trims
from plumbob.engines.own_motion import OwnModel

UNITS = MappingProxyType({"momentum": "kg m/s", "penetration": "m", "slip": "m/s"})
NOTICED = 1e-6  # [m]: a smaller error at an earlier time is not mentioned
RISK = (
    ', and <flag refsafe="disable"/> in it, at a risk: contacts too stiff for the step, which it '
    "no longer softens, may throw bodies"
)


def lines(audit: Audit) -> list[str]:
    """The answer as lines of text."""
    return aligned(rows(audit))


def aligned(entries: Sequence[tuple[str, str]]) -> list[str]:
    """Names and what they say, below each other."""
    width = max(len(name) for name, _ in entries) + 2
    return [f"{name:{width}}{text}" for name, text in entries]


def rows(audit: Audit) -> list[tuple[str, str]]:
    """The answer: names of the lines, and what they say."""
    script = audit.script
    head = f"{audit.integrator} {duration(audit.step)}, {script.duration:.3g} s"
    entries = [
        (Path(audit.name).name, f"{head}, control ({audit.control}) held {duration(script.period)}")
    ]
    entries += [("reference", _reference(audit))]
    if audit.found is not None:
        entries += list(_compared(audit, audit.found))
    entries += [("to do", to_do(audit)), ("model", _model(audit))]
    if audit.slides:
        entries += [("more", f"{audit.slides} rests on a plane: --contacts tells how it slides")]
    beyond = "" if audit.found is None else f"; t > {audit.until:.3g} s"
    return [*entries, ("not claimed", f"other motions; reality{beyond}")]


def _compared(audit: Audit, steps: Compared) -> Iterator[tuple[str, str]]:
    as_is = steps.own
    if audit.still:
        yield "your error", "none: nothing moves under this control"
        return
    if as_is.why and math.isinf(audit.error):
        yield "your error", as_is.why
    elif audit.resolved:
        yield "your error", f"{length(audit.error)} (worst body: {as_is.worst})"
    else:
        most = length(audit.error + audit.uncertainty)
        before = ""
        if (last := audit.resolved_index) and as_is.at(last) > NOTICED:
            before = f"; {length(as_is.at(last))} at {audit.script.times[last]:.3g} s"
        yield "your error", f"at most {most}: no more than the reference is known to{before}"
    yield "halving", _halving(audit, steps)
    yield "cheapest", _cheapest(steps)
    yield "predictable", _predictable(audit, steps)
    if audit.likely is not None:
        yield "likely", _likely(audit.likely)
    yield "contacts", _contacts(audit)
    if audit.balances:
        yield "balance", "; ".join(balance(b) for b in audit.balances)
    if audit.trims is not None:
        yield "trims", _trims(audit.trims)
    if audit.written is not None:
        yield "trimmed file", _written(audit, *audit.written)


def _reference(audit: Audit) -> str:
    reference = audit.reference
    if audit.found is None:
        return f"none: {reference.why or 'two computations do not agree'}"
    how = "two methods"
    if reference.widths:
        how = f"layers of {len(reference.widths)} widths"
    known = f"certified to ±{audit.uncertainty:.1e} m over {audit.until:.3g} s"
    nearest = f"its own steps come within {length(steps_nearest(audit.found))} of it"
    ended = f"; then: {reference.why}" if reference.why else ""
    return f"{known} ({how}; {nearest}){ended}"


def _likely(means: Likely) -> str:
    name, apart = means.most
    known = f"over {means.starts} starts at the end, {FINER} times as many steps"
    if apart < STANDS_OUT:
        return f"{known} change no mean by more than {apart:.2g} standard errors"
    k = MEANS.index(name)
    values = f"{length(abs(means.own[k] - means.finer[k]))}, {apart:.2g} standard errors"
    return f"{known} change the {name} of the bodies by {values}"


def _contacts(audit: Audit) -> str:
    events = len(audit.reference.course.events)
    rate = events / max(audit.reference.course.until, audit.script.period)
    counted = f"{events} begin or end along the reference, {rate:.2g} a second"
    counted = counted if events else "none changes"
    return "; ".join(part for part in (counted, audit.reference.not_smooth) if part)


def balance(read: Balance) -> str:
    """A reading at the own step beside the continuous motion's, in words."""
    unit = UNITS.get(read.name, "m or rad")
    if read.name == "energy":
        return f"energy differs by {read.apart:.2g} J; it changes by {read.continuous:.2g} J"
    if read.name == "momentum":
        return f"momentum differs by {read.apart:.2g} of {read.continuous:.2g} {unit}"
    return f"{read.name} {read.own:.2g} {unit}, continuously {read.continuous:.2g} {unit}"


def _trims(trims: Trims) -> str:
    if trims.together is None:
        return "nothing that saves anything and leaves the motion as it is"
    return f"without {trims.together.name}: {trim_effect(trims.together)}; on this motion only"


def _written(audit: Audit, file: str, read_back: Trim) -> str:
    moves = f"to the last bit as the whole model does over {audit.script.duration:.3g} s"
    if not read_back.same_bits:
        apart = length(read_back.moved)
        moves = f"up to {apart} apart from the whole model over {audit.until:.3g} s"
    cost = times(read_back.cost)
    return f"{file}, read back, moves {moves} of this motion{cost}; without {read_back.name}"


def trim_effect(trim: Trim) -> str:
    """The effect of an ablation, in words."""
    moves = "same bits" if trim.same_bits else f"moves {length(trim.moved)}"
    return f"{moves}{times(trim.cost)}"


def times(cost: Ratio | None) -> str:
    """A cost in multiples of the model's own, with its spread; empty where there is none."""
    if cost is None:
        return ""
    if cost.low == cost.high:
        return f" (×{cost.value:.2g})"
    return f" (×{cost.value:.2g} [{cost.low:.2g}, {cost.high:.2g}])"


def steps_nearest(steps: Compared) -> float:
    """The smallest error [m] of all steps that were run."""
    return steps.nearest


def _halving(audit: Audit, steps: Compared) -> str:
    finer = [s for s in steps.steps if s.integrator == audit.integrator and s.step <= audit.step]
    errors = [s.at(steps.index) for s in finer]
    if math.isinf(errors[0]):
        finite = [s for s in finer if math.isfinite(s.at(steps.index))]
        if not finite:
            return f"no step of it holds, down to {duration(finer[-1].step)}"
        return f"needed: from {duration(finite[0].step)} on it holds"
    known = RESOLVED * audit.uncertainty
    if not audit.resolved:
        return f"not resolved: the reference tells errors from {length(known)} on"
    shown = [e for e in errors if e > known][:5]
    chain = " -> ".join(map(length, shown))
    if len(shown) < 2:
        below = [f"at most {length(e + audit.uncertainty)}" for e in errors[1:2]]
        return " -> ".join((chain, *below)) + ": the reference tells no more"
    ratio = (shown[-1] / shown[0]) ** (1 / (len(shown) - 1))
    helps = "helps" if ratio < 0.71 else "hardly helps" if ratio < 0.95 else "does not help"
    if steps.order is None:
        return f"{helps}: {chain}"
    order = steps.order
    interval = f"{order.slope:.2g} [{order.low:.2g}, {order.high:.2g}]"
    return f"{helps}: {chain}; observed order {interval}"


def _cheapest(steps: Compared) -> str:
    parts = []
    for target in TARGETS:
        best = next((c for c in steps.cheapest if c.target == target), None)
        if best is None:
            parts.append(f"{length(target)}: none found")
        else:
            choice = f"{best.integrator} {duration(best.step)}"
            parts.append(f"{length(target)}: {choice}{times(best.cost)}")
    return "   ".join(parts)


def _predictable(audit: Audit, steps: Compared) -> str:
    parts = []
    for target in TARGETS[1:3]:
        first = horizon(steps, audit.reference, audit.script, target)
        until = f"all of {audit.until:.3g} s" if math.isinf(first) else f"to {first:.3g} s"
        parts.append(f"{length(target)}: {until}")
    return "   ".join(parts)


def _model(audit: Audit) -> str:
    clamped = sum(audit.clamped.values())
    step = duration(audit.step)
    clamping = f"refsafe clamps nothing at {step}"
    if clamped:
        fields = ", ".join(audit.clamped)
        many = "1 time constant" if clamped == 1 else f"{clamped} time constants"
        clamping = f"refsafe raises {many} at {step} ({fields})"
    remarks = audit.found.own.remarks if audit.found else ()
    return "; ".join([clamping, *audit.notes, *remarks])


def to_do(audit: Audit) -> str:
    """The advice that follows for the model's file, or for the next audit."""
    steps = audit.found
    if steps is None or audit.model is None:
        return "try a shorter --duration, a larger --budget, another --keyframe or --ctrl"
    if not audit.error:
        driven = audit.control not in ("rest", "zero")
        return (
            f"move it: {'another --keyframe' if driven else '--ctrl sines'}, or a file of controls"
        )
    parts = []
    better = next((c for c in steps.cheapest if c.target < audit.error), None)
    enough = [c for c in steps.cheapest if c.target >= audit.error + audit.uncertainty]
    saves = enough and enough[-1].cost is not None and enough[-1].cost.saves
    if better is not None:
        parts.append(_choice(audit.model, better, "for"))
    complete = audit.until >= audit.script.duration * (1 - 1e-9)
    if complete and saves:
        parts.append(_choice(audit.model, enough[-1], "enough for"))
    if not parts:
        nearer = min(TARGETS) < audit.error
        parts = ["no step that was run is reliably nearer" if nearer else "keep the step"]
    if not complete:
        parts[-1] += f" up to {audit.until:.3g} s"
    if OUT_OF_TIME in audit.reference.why:
        parts.append("a larger --budget tells more")
    if steps.own.remarks:
        parts.append("give the solver more iterations, or choose Newton's")
    if audit.clamped:
        least, fields = duration(2.0 * audit.step), ", ".join(audit.clamped)
        parts.append(f"before another step, raise {fields} to {least} in the file")
    return "; ".join(parts)


def _choice(model: OwnModel, chosen: Cheapest, what: str) -> str:
    replaced = " and ".join(
        f'{name}="{then}" in place of {now}'
        for name, (now, then) in model.option(chosen.integrator, chosen.step).items()
    )
    risk = RISK if chosen.unguarded else ""
    return f"{what} {length(chosen.target)}: in <option> {replaced}{risk}{times(chosen.cost)}"


def length(metres: float) -> str:
    """A length [m] with two digits, in the unit that suits it."""
    if not math.isfinite(metres):
        return "diverged"
    for unit, size in (("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9)):
        if metres >= 0.9995 * size:
            return f"{float(f'{metres / size:.2g}'):g} {unit}"
    return f"{metres:.1e} m" if metres else "0"


def duration(seconds: float) -> str:
    """A time step [s] in the unit that suits it."""
    if seconds >= 1.0:
        return f"{seconds:.3g} s"
    return f"{1e3 * seconds:.3g} ms" if seconds >= 1e-3 else f"{1e6 * seconds:.3g} µs"
