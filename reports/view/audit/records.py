"""An audit as plain data, as JSON has it."""

from __future__ import annotations

from typing import Any

from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.contacts import HEADINGS, ContactAudit, ContactRun
from plumbob.engines.audit.costs import Ratio
from plumbob.engines.audit.engines import EngineError
from plumbob.engines.audit.gradient import CertifiedGradient
from plumbob.engines.audit.reference import MEASURE
from plumbob.engines.audit.stability import LargestSteps, Limit
from plumbob.engines.audit.step_errors import StateErrors, StepComparison
from plumbob.engines.audit.trims import Trim
from plumbob.engines.derivative_ways import CENTRAL
from plumbob.reports.advice.json_records import plain
from plumbob.reports.view.audit.page import answered, rows, versions

Plain = dict[str, Any]
"""A record as JSON has it."""


def record(audit: Audit | ContactAudit) -> Plain:
    """An audit as plain data: what `--json` prints."""
    return dict(plain(_contacts(audit) if isinstance(audit, ContactAudit) else _motion(audit)))


def _named(of: object, *names: str) -> Plain:
    return {name: getattr(of, name) for name in names}


def _motion(audit: Audit) -> Plain:
    steps = audit.found

    def trim(ablation: Trim) -> Plain:
        done = {"left_out": ablation.name, **_named(ablation, "same_bits", "moved")}
        return {**done, "accepted": ablation.accepted(audit.error), **spread(ablation.cost)}

    return {
        "model": audit.name,
        **_named(audit, "integrator", "step", "control"),
        "control_period": audit.script.period,
        "duration": audit.script.duration,
        "certified_until": audit.until,
        **_named(audit, "uncertainty", "error"),
        "error_measure": MEASURE,
        **_of_states(audit.state_errors),
        "resolved_until": float(audit.script.times[audit.resolved_index]),
        "resolved": audit.resolved if steps else False,
        "why": audit.reference.why,
        "not_smooth": audit.reference.not_smooth,
        "layer_widths": audit.reference.widths,
        "events": audit.reference.course.events,
        "clamped": audit.clamped,
        "notes": (*audit.notes, *(steps.own.remarks if steps else ())),
        "unchecked": audit.model.unchecked,
        "to_do": dict(rows(answered(audit)))["to do"],
        **_steps(steps),
        "balances": audit.balances,
        "trims": []
        if audit.trims is None
        else [trim(t) for t in (*audit.trims.each, *filter(None, [audit.trims.together]))],
        "trimmed_file": None if audit.written is None else trim(audit.written[1]),
        "start": audit.script.start,
        "pose": audit.pose,
        "corners": audit.corners,
        "fields": audit.model.fields,
        "versions": versions(),
        **stability_record(audit.stability),
        **gradient_record(audit.gradient),
        **({} if audit.changes is None else {"changes": audit.changes}),
        **({"engines": list(map(_engine, audit.engines))} if audit.engines else {}),
        "seconds": audit.seconds,
    }


def _of_states(errors: StateErrors | None) -> Plain:
    """Errors of attitudes [rad], joint coordinates [rad or m] and activations, as plain data."""
    return {
        "attitude_error": errors and errors.attitude,
        "coordinate_error": errors and errors.coordinates,
        "activation_error": errors and errors.activations,
    }


def _steps(found: StepComparison | None) -> Plain:
    """The own step's error over time [m], order, and errors and costs of other steps, as plain
    data."""
    if found is None:
        return {
            "worst_body": None,
            "error_over_time": [],
            "order": None,
            "steps": [],
            "cheapest": [],
        }
    steps = [
        {
            **_named(s, "integrator", "step"),
            "error": s.at(found.index),
            **_named(s, "ns_per_second", "why", "cost"),
        }
        for s in found.steps
    ]
    return {
        "worst_body": found.own.worst,
        "error_over_time": found.own.errors[: found.index + 1],
        "order": found.order,
        "steps": steps,
        "cheapest": [{**c.__dict__, **spread(c.cost)} for c in found.cheapest],
    }


def _engine(row: EngineError) -> Plain:
    """An engine's error [m], and what differs first, as plain data."""
    return {
        **_named(row, "engine", "version", "error"),
        **_of_states(row.state_errors),
        "error_over_time": row.errors,
        "first_term": row.first and row.first.term,
        "difference": row.first and (row.first.cause or f"by {row.first.size:.2g} of it"),
        "part_explained": row.part_explained,
        "why": row.reason,
        **_named(row, "left", "built", "not_built", "step_error", "apart"),
        "single_precision": row.rounding,
        "terms": row.differences,
    }


def stability_record(known: LargestSteps | None) -> Plain:
    """The largest steps that hold [s], and what raises the own integrator's, as plain data."""

    def limit(largest: Limit) -> Plain:
        names = (
            "integrator",
            "largest_step",
            "first",
            "confirmed",
            "why",
            "predicted",
            "chatters",
            "holds_to",
        )
        return _named(largest, *names)

    assert known is not None
    return {
        "stability": list(map(limit, known.limits)),
        "unstable": known.unstable,
        "remedies": [
            {"change": r.change.name, **limit(r.limit), "moved": r.moved}
            for r in known.remedies
        ],
    }


def gradient_record(known: CertifiedGradient | str | None) -> Plain:
    """Derivatives of the end, their horizon [s] and best eps, as plain data; nothing where they are
    not asked for."""
    if known is None:
        return {}
    if isinstance(known, str):
        return {
            "gradient": [],
            "gradient_horizon": None,
            "gradient_lost": [],
            "gradient_why": known,
        }
    measured = next(way.eps for way in known.ways if way.name == CENTRAL.name)
    return {
        "gradient": known.entries,
        "gradient_horizon": known.horizon,
        "gradient_lost": known.lost,
        "gradient_why": known.why,
        "gradient_ways": {way.name: way.why for way in known.ways},
        "gradient_left_out": known.left_out,
        "best_eps": {"predicted": known.predicted_eps, "measured": measured},
    }


def spread(cost: Ratio | None) -> Plain:
    """A cost in multiples of the model's own, and what its quartiles leave open, as plain data."""
    if cost is None:
        return {"cost": None, "spread": None}
    return {"cost": cost.value, "spread": [cost.low, cost.high]}


def _contacts(audit: ContactAudit) -> Plain:
    def run(measured: ContactRun, predicted: Any = None) -> Plain:
        return {
            **_named(measured, "step", "distances"),
            "errors": audit.errors(measured),
            "predicted_errors": predicted,
            "direction_dependence": audit.dependence(measured),
            **_named(measured, "turned", "drift"),
            "turn": measured.turning.turn
            if measured.turning and measured.turning.rests
            else None,
        }

    return {
        "model": audit.name,
        **_named(audit, "integrator", "step"),
        "body": audit.standing,
        **_named(audit, "speed", "spin"),
        "headings": HEADINGS,
        "distance": audit.exact,
        "not_determined": audit.why,
        "compared_with": audit.distances,
        "known_to": audit.known,
        "turn": audit.exact_turn,
        "turn_not_determined": audit.why_turn,
        "turn_compared_with": audit.exact_turn,
        "turn_known_to": None if audit.exact_turn is None else 0.0,
        "joints_free": audit.free,
        "own": [run(measured) for measured in audit.own],
        "pasted": [run(measured, audit.predicted(measured)) for measured in audit.pasted],
        "not_run": audit.failed,
        **_named(audit.model, "method", "stiffness"),
        "to_paste": audit.snippet,
        "notes": audit.model.notes,
        "versions": versions(),
        "seconds": audit.seconds,
    }
