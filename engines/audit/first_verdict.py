"""First verdict on a user model: what two runs of its own steps tell, before any reference."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from plumbob.engines.audit.reference import largest_displacement
from plumbob.engines.own_motion import OwnModel, Script
from plumbob.engines.registry import method

MODELS_ENGINE = "mujoco"  # engine whose integrators a user model names


@dataclass(frozen=True)
class FirstVerdict:
    """The difference that half the step makes, and the error that it suggests."""

    duration: float  # [s] of both runs
    ends_at: float | None  # [s] time at which the run at the model's own step ends early
    why: str  # why it ends early; empty if it does not
    # [m] largest displacement of a corner by half the step; nan if a run ends early
    change: float
    estimate: float  # [m] estimated error at the model's own step, from the integrator's order
    remarks: tuple[str, ...]  # remarks about the run at the model's own step


def affordable(model: OwnModel, script: Script, seconds: float) -> Script | None:
    """Returns the begin of a script for which a run at the model's own step and a run at half of it
    take about `seconds` [s] of processor time, by the time of one step; None if that is less than a
    period of controls."""
    single_step = replace(script, period=model.step, controls=script.controls[:1])
    step_seconds = model.stepped(single_step, model.integrator, 1).seconds
    of_period = (1 + 2) * script.parts(model.step) * step_seconds
    count = len(script.controls)
    periods = count if count * of_period <= seconds else math.floor(seconds / of_period)
    return replace(script, controls=script.controls[:periods]) if periods else None


def first_verdict(model: OwnModel, script: Script) -> FirstVerdict:
    """Returns the verdict of a run at the model's own step and of a run at half of it. If errors go
    as step^p with the integrator's order p, the error is 2^p/(2^p - 1) times their difference:
    contacts lower the order, so that it is an estimate and no bound."""
    parts = script.parts(model.step)
    own, halved = (model.stepped(script, model.integrator, parts * k) for k in (1, 2))
    ends_at = None
    if own.why:
        known = np.isfinite(own.states).all(axis=1)
        ends_at = float(script.times[known].max(initial=0.0))
    change = math.nan
    if not own.why and not halved.why:
        change = largest_displacement(model, own.states, halved.states)
    ratio = 2.0 ** (method(f"{MODELS_ENGINE}/{model.integrator}").order or 1)
    return FirstVerdict(
        duration=script.duration,
        ends_at=ends_at,
        why=own.why,
        change=change,
        estimate=change * ratio / (ratio - 1.0),
        remarks=own.remarks,
    )
