"""The JSON data of an audit."""

from __future__ import annotations

import math
from typing import Any

from plumbob.engines.audit.audit import Audit
from plumbob.engines.audit.contacts import HEADINGS, ContactAudit, ContactRun
from plumbob.engines.audit.costs import Ratio
from plumbob.engines.audit.engines import EngineError
from plumbob.engines.audit.environment_returns import MotionReturn
from plumbob.engines.audit.gradient import CertifiedGradient
from plumbob.engines.audit.holds import (
    LONG_CREEP,
    SHORT_CREEP,
    CreepRemedy,
    GroupVerdict,
    HoldsAudit,
)
from plumbob.engines.audit.loop_stability import LoopStability
from plumbob.engines.audit.mean_returns import EpisodeReturns, MeanInterval
from plumbob.engines.audit.reference import MEASURE
from plumbob.engines.audit.stability import LargestSteps, Limit
from plumbob.engines.audit.step_errors import StateErrors, StepComparison
from plumbob.engines.audit.trims import Trim
from plumbob.engines.derivative_ways import CENTRAL
from plumbob.engines.difference.repetitions import RepeatedMotion, Repetition
from plumbob.reports.advice.audit_advice import StepChoice, audit_advice
from plumbob.reports.advice.fixed_file import FixedFile
from plumbob.reports.records.plain_data import FOR_JSON, plain
from plumbob.reports.view.audit.page import (
    AnyAudit,
    holds_snippet,
    package_versions,
    to_do_text,
)

Plain = dict[str, Any]
"""A record as a JSON object."""


def record(audit: AnyAudit) -> Plain:
    """Returns an audit as the JSON object that `--json` prints."""
    if isinstance(audit, ContactAudit):
        values = _contacts_record(audit)
    elif isinstance(audit, HoldsAudit):
        values = _holds_record(audit)
    elif isinstance(audit, RepeatedMotion):
        values = _repeated_record(audit)
    else:
        values = _motion_record(audit)
    return dict(plain(values, FOR_JSON))


def _repeated_record(audit: RepeatedMotion) -> Plain:
    """Returns the repetitions of a motion as a JSON object."""
    return {
        "model": audit.name,
        **_attributes(audit.model, "integrator", "step"),
        "control": audit.control,
        "control_period": audit.script.period,
        "duration": float(audit.recording.times[-1]),
        "reproducible": not audit.beyond,
        "repetitions": [_repetition_record(row) for row in audit.repetitions],
        "versions": package_versions(),
        "seconds": audit.seconds,
    }


def _repetition_record(row: Repetition) -> Plain:
    """Returns a repetition of a motion as a JSON object."""
    difference = row.difference
    if difference is not None and difference.first is not None:
        reached = difference.reached
        band: Plain | None = {
            "first": difference.first,
            "largest": difference.largest,
            "largest_use": difference.largest_use,
            "until": difference.until,
            "why": difference.why,
            "estimate": difference.estimates[reached],
            "bound": difference.bounds[reached],
            "solver_bound": difference.solver[reached],
        }
    else:
        band = None
    return {
        **_attributes(row, "name", "kind", "verdict", "why", "factor", "begin", "end"),
        "band": band,
        "steps": row.steps,
        "solver_leaves": row.solver and row.solver.largest,
        "own_solver_leaves": row.own_solver and row.own_solver.largest,
        "most_iterations": row.solver and row.solver.iterations,
        "steps_at_cap": row.solver and row.solver.at_cap,
    }


def _attributes(instance: object, *names: str) -> Plain:
    """Returns the named attributes of an instance, by name."""
    return {name: getattr(instance, name) for name in names}


def _motion_record(audit: Audit) -> Plain:
    """Returns an audit of a motion as a JSON object."""
    comparison = audit.found
    advice = audit_advice(audit)
    return {
        # the model and its motion
        "model": audit.name,
        **_attributes(audit, "integrator", "step", "control"),
        "control_period": audit.script.period,
        "duration": audit.script.duration,
        "certified_until": audit.until,
        # the errors of the model's step
        **_attributes(audit, "uncertainty", "error"),
        "error_measure": MEASURE,
        **_loop_record(audit),
        **_state_errors_record(audit.state_errors),
        "resolved_until": float(audit.script.times[audit.resolved_index]),
        "resolved": audit.resolved if comparison else False,
        # the reference, and what limits it
        "why": audit.reference.why,
        "not_smooth": audit.reference.not_smooth,
        "layer_widths": audit.reference.widths,
        "events": audit.reference.course.events,
        "clamped": audit.clamped,
        "notes": (*audit.notes, *(comparison.own.remarks if comparison else ())),
        "unchecked": audit.model.unchecked,
        # advice, and the errors and costs of other steps
        "to_do": to_do_text(audit, advice),
        **_steps_record(comparison),
        "cheapest": [step_choice_record(choice) for _, choice in advice.cheapest if choice],
        # balances, and parts that can be left out
        "balances": audit.balances,
        "trims": _trim_records(audit),
        "trimmed_file": _trim_record(audit, audit.written.read_back) if audit.written else None,
        # data with which the audit can be repeated
        "start": audit.script.start,
        "pose": audit.pose,
        "corners": audit.corners,
        "fields": audit.model.fields,
        "versions": package_versions(),
        # the largest stable steps, and what else the user asked for
        **stability_record(audit.stability),
        **gradient_record(audit.gradient),
        **({} if audit.changes is None else {"changes": audit.changes}),
        **({"engines": list(map(_engine_record, audit.engines))} if audit.engines else {}),
        **_motion_return_record(audit.motion_return),
        **_returns_record(audit.returns),
        "seconds": audit.seconds,
    }


def fixed_record(fixed: FixedFile) -> Plain:
    """Returns a file into which the advice of an audit is written, as a JSON object: its options,
    and the errors [m] before, as promised, and as its own audit found them."""
    return {
        "file": str(fixed.path),
        "place": fixed.place,
        "options": fixed.choice.new_options,
        "refsafe_disabled": fixed.choice.unguarded,
        **_attributes(fixed, "until", "before", "promised", "error", "uncertainty", "kept"),
        "why": fixed.audit.reference.why,
        **spread(fixed.choice.cost),
    }


def _loop_record(audit: Audit) -> Plain:
    """Returns the error [m] with replayed controls and the factor of feedback of an audit in the
    loop; nothing for other audits."""
    if audit.script.loop is None:
        return {}
    replayed = None if math.isnan(audit.replayed_error) else audit.replayed_error
    return {"replayed_error": replayed, "feedback_factor": audit.feedback_factor}


def _returns_record(returns: EpisodeReturns | None) -> Plain:
    """Returns the mean returns of episodes at each step, and their limit; nothing without
    episodes."""
    if returns is None:
        return {}
    rows = [
        {
            **_attributes(row, "engine", "integrator", "step"),
            "mean": row.mean.mean,
            **_interval_record(row.difference),
            **_attributes(row, "episodes", "lost", "length"),
        }
        for row in returns.rows
    ]
    limit = _interval_record(returns.limit) if returns.limit else None
    return {"returns": rows, "return_limit": limit, "return_limit_why": returns.no_limit}


def _motion_return_record(found: MotionReturn | None) -> Plain:
    """Returns the return of an environment's motion; nothing for other audits."""
    return {} if found is None else {"motion_return": vars(found)}


def _interval_record(interval: MeanInterval | None) -> Plain:
    """Returns the difference of a mean return with its intervals; None for each without one."""
    names = ("low", "high", "bootstrap_low", "bootstrap_high")
    return {
        "difference": interval and interval.mean,
        **{name: interval and getattr(interval, name) for name in names},
    }


def _trim_records(audit: Audit) -> list[Plain]:
    """Returns the trials of leaving out single features, and of leaving out all of them
    together."""
    if audit.trims is None:
        return []
    trials = [*audit.trims.each]
    if audit.trims.together:
        trials.append(audit.trims.together)
    return [_trim_record(audit, trial) for trial in trials]


def _trim_record(audit: Audit, trial: Trim) -> Plain:
    """Returns the trial of a model without some features: the change of the motion and the cost."""
    return {
        "left_out": trial.name,
        **_attributes(trial, "same_bits", "moved"),
        "accepted": trial.accepted(audit.error),
        **spread(trial.cost),
    }


def _state_errors_record(errors: StateErrors | None) -> Plain:
    """Returns errors of attitudes [rad], joint coordinates [rad or m] and activations; each is None
    if it is not known."""
    return {
        "attitude_error": errors and errors.attitude,
        "coordinate_error": errors and errors.coordinates,
        "activation_error": errors and errors.activations,
    }


def _steps_record(comparison: StepComparison | None) -> Plain:
    """Returns the error of the model's step over time [m], its order of convergence, and the errors
    and costs of other steps and integrators."""
    if comparison is None:
        return {
            "worst_body": None,
            "error_over_time": [],
            "order": None,
            "steps": [],
        }
    steps = [
        {
            **_attributes(run, "integrator", "step"),
            "error": run.at(comparison.index),
            **_attributes(run, "ns_per_second", "why", "cost"),
        }
        for run in comparison.steps
    ]
    return {
        "worst_body": comparison.own.worst,
        "error_over_time": comparison.own.errors[: comparison.index + 1],
        "order": comparison.order,
        "steps": steps,
    }


def step_choice_record(choice: StepChoice) -> Plain:
    """Returns the integrator and step that are advised for a wanted error, with the cheaper run
    that is not advised and the reason."""
    names = ("target", "integrator", "step", "error", "unguarded", "limit")
    over = choice.passed_over
    return {
        **_attributes(choice, *names),
        **spread(choice.cost),
        "passed_over": over
        and {
            **_attributes(over, "integrator", "step", "limit", "worse"),
            **spread(over.cost),
        },
    }


def _engine_record(row: EngineError) -> Plain:
    """Returns an engine's error [m] and the first term in which it differs from the model."""
    return {
        **_attributes(row, "engine", "version", "error"),
        **_state_errors_record(row.state_errors),
        "error_over_time": row.errors,
        "first_term": row.first and row.first.term,
        "difference": row.first and (row.first.cause or f"by {row.first.size:.2g} of it"),
        "part_explained": row.part_explained,
        "why": row.reason,
        **_attributes(row, "left", "built", "not_built", "step_error", "apart"),
        "single_precision": row.rounding,
        "terms": row.differences,
    }


def stability_record(known: LargestSteps | None) -> Plain:
    """Returns the largest stable step [s] of each integrator, and the remedies that raise the
    largest step of the model's integrator."""

    assert known is not None
    remedies = [
        {"change": remedy.change.name, **_limit_record(remedy.limit), "moved": remedy.moved}
        for remedy in known.remedies
    ]
    return {
        "stability": list(map(_limit_record, known.limits)),
        "unstable": known.unstable,
        "remedies": remedies,
    }


def _limit_record(largest: Limit) -> Plain:
    """Returns the largest stable step of one integrator, and how it was found."""
    searched = _attributes(largest, "integrator", "largest_step", "first", "confirmed", "why")
    return {**searched, **_attributes(largest, "predicted", "chatters", "holds_to")}


def loop_record(loop: LoopStability) -> Plain:
    """Returns the stability of a model under a policy about a fixed point, and the stable intervals
    of hold [s], delay [s] and gain."""
    names = ("integrator", "step", "hold", "delay", "multiplier", "unstable", "by_jacobian")
    intervals = [
        {
            **_attributes(interval, "quantity", "own"),
            "low": interval.low and vars(interval.low),
            "high": interval.high and vars(interval.high),
        }
        for interval in loop.intervals
    ]
    return {
        **_attributes(loop, *names),
        "state": loop.state.tolist(),
        "control": loop.control.tolist(),
        "intervals": intervals,
    }


def gradient_record(known: CertifiedGradient | str | None) -> Plain:
    """Returns derivatives of the final state, their horizon [s] and the best eps of differences;
    empty if no derivatives were asked for."""
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
    """Returns a cost in multiples of the cost of the model's step, and its spread, from quartile to
    quartile; both None if it was not measured."""
    if cost is None:
        return {"cost": None, "spread": None}
    return {"cost": cost.value, "spread": [cost.low, cost.high]}


def _contact_run_record(
    audit: ContactAudit, measured: ContactRun, predicted: Any = None
) -> Plain:
    """Returns one run of a contact audit, with the errors that theory predicts, if there are
    any."""
    rotated_slide = measured.turning  # the slide that begins with a rotation
    return {
        **_attributes(measured, "step", "distances"),
        "errors": audit.errors(measured),
        "predicted_errors": predicted,
        "direction_dependence": audit.dependence(measured),
        **_attributes(measured, "turned", "drift"),
        "turn": rotated_slide.turn if rotated_slide and rotated_slide.rests else None,
    }


def _contacts_record(audit: ContactAudit) -> Plain:
    """Returns a contact audit as a JSON object."""
    return {
        "model": audit.name,
        **_attributes(audit, "integrator", "step"),
        "body": audit.standing,
        **_attributes(audit, "speed", "spin"),
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
        "own": [_contact_run_record(audit, run) for run in audit.own],
        "pasted": [
            _contact_run_record(audit, run, audit.predicted(run)) for run in audit.pasted
        ],
        "not_run": audit.failed,
        **_attributes(audit.model, "method", "stiffness"),
        "to_paste": audit.snippet,
        "notes": audit.model.notes,
        "versions": package_versions(),
        "seconds": audit.seconds,
    }


def _holds_record(audit: HoldsAudit) -> Plain:
    """Returns an audit of what holds as a JSON object."""
    worst = audit.worst.statics
    creep = audit.creep
    return {
        "model": audit.name,
        **_attributes(audit, "integrator", "step"),
        "holds": {
            "coulomb": audit.coulomb,
            "margin": worst.margin,
            "judged_at": "start" if audit.at_start else "settled",
            "moved": audit.moved,
            "groups": list(map(_group_record, audit.groups)),
            "creep": creep.speed,
            "steady": creep.steady,
            "predicted_creep": audit.predicted,
            "distances": [creep.distances.get(time) for time in (SHORT_CREEP, LONG_CREEP)],
            "wanted_creep": audit.wanted,
            "options": audit.model.options,
            "to_paste": holds_snippet(audit),
            "tried": list(map(_remedy_record, audit.tried)),
        },
        "versions": package_versions(),
        "seconds": audit.seconds,
    }


def _group_record(verdict: GroupVerdict) -> Plain:
    """Returns what Coulomb's law says about bodies that are connected."""
    statics = verdict.statics
    forces = statics.normal_forces.tolist() or [None] * len(verdict.group.pairs)
    contacts = [
        {"pair": pair, "friction": friction, "normal_force": force}
        for pair, friction, force in zip(
            verdict.group.pairs, verdict.group.coefficients, forces, strict=True
        )
    ]
    return {
        "bodies": verdict.group.bodies,
        "coulomb": verdict.coulomb,
        **_attributes(
            statics, "margin", "least_friction", "least_force", "least_actuation", "least_grip"
        ),
        "contacts": contacts,
    }


def _remedy_record(remedy: CreepRemedy) -> Plain:
    """Returns options that were tried against creep."""
    return {
        "options": remedy.options,
        "creep": remedy.creep.speed,
        "depth": remedy.creep.depth,
        **_attributes(remedy, "cost", "refusal"),
    }
