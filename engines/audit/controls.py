"""Controls that drive a model during its audit. They are held over periods and can be replayed."""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.analytic.reference import Array
from plumbob.engines.own_motion import OwnModel, Script, periods
from plumbob.models.border import must_be

PERIOD = 0.02  # [s] approximate time for which a control is held
DURATION = 1.0  # [s] default duration of a motion
AMPLITUDE = 0.3  # amplitude of a sine, as a fraction of half a control's range
# [Hz] frequency of the first sine, and difference of successive frequencies
FREQUENCY, APART = 0.7, 0.13
MOST = 100_000  # most periods, and most steps in a period
KINDS = ("rest", "zero", "sines")


def held_period(model: OwnModel, period: float) -> float:
    """Returns the multiple of the model's step that is nearest to `period` [s]. Raises
    ParameterError."""
    wanted = positive("ctrl period", period)
    if wanted > MOST * model.step:
        raise ParameterError("ctrl period", wanted, f"at most {MOST} steps of {model.step:g} s")
    return max(1, round(wanted / model.step)) * model.step


def possible_duration(duration: float | None, period: float) -> float:
    """Returns a duration [s], by default DURATION, if it is positive and has few enough periods
    [s]. Raises ParameterError."""
    if duration is None:
        return DURATION
    if positive("duration", duration) > MOST * period:
        raise ParameterError("duration", duration, f"at most {MOST} periods of {period:g} s")
    return duration


def script(
    model: OwnModel,
    control: str | Array = "rest",
    duration: float | None = None,
    period: float | None = None,
) -> Script:
    """Returns the start of `model` and its controls. "rest" keeps the control of the start, "zero"
    applies none, and "sines" moves each actuator about the control of the start by a sine of its
    own; otherwise `control` has the values, shape (periods, actuators). A control is held for the
    multiple of the model's step that is nearest to `period` [s]. The controls last to the end of
    the period in which `duration` [s] ends, or as long as the values. Raises ParameterError."""
    held = held_period(model, PERIOD if period is None else period)
    if duration is not None:
        duration = possible_duration(duration, held)
    if isinstance(control, str):
        count = max(1, round(DURATION / held)) if duration is None else periods(duration, held)
        values = _named_controls(
            model, control, np.asarray(held * np.arange(count), dtype=float)
        )
    else:
        values = _checked_controls(model, control)
        if duration is not None:
            values = values[: periods(duration, held)]
        if len(values) > MOST:
            raise ParameterError("ctrl", f"{len(values)} periods", f"at most {MOST}")
    return Script(model.state, held, values)


def _named_controls(model: OwnModel, control: str, times: Array) -> Array:
    """Returns the named controls at `times` [s], shape (periods, actuators)."""
    if control not in KINDS:
        raise ParameterError("ctrl", control, f"{', '.join(KINDS)}, or values {_shape(model)}")
    if control == "zero":
        return np.zeros((times.size, model.rest.size))
    if control == "rest":
        return np.tile(model.rest, (times.size, 1))
    low, high = model.ranges.T
    limited = np.isfinite(low)
    half = np.where(limited, (high - low) / 2, 1.0)
    centre = np.where(limited, (high + low) / 2, 0.0) if not model.rest.any() else model.rest
    i = np.arange(model.rest.size)
    rates = 2 * np.pi * (FREQUENCY + APART * i)
    wave = centre + AMPLITUDE * half * np.sin(rates * times[:, None] + i)
    return np.where(limited, np.clip(wave, low, high), wave)


def _shape(model: OwnModel) -> str:
    """Names the shape of controls."""
    return f"of shape (periods, {model.rest.size})"


def _checked_controls(model: OwnModel, control: Any) -> Array:
    """Returns given controls as numbers, shape (periods, actuators). Raises ParameterError."""
    wanted = _shape(model)
    what = f"{', '.join(KINDS)}, or numbers {wanted}"
    with must_be(what, "ctrl", type(control).__name__):
        values = np.asarray(control, dtype=float)
    values = values[:, None] if values.ndim == 1 else values
    if values.shape[1:] != (model.rest.size,) or not len(values):
        raise ParameterError("ctrl", f"shape {values.shape}", wanted)
    if not np.isfinite(values).all():
        raise ParameterError("ctrl", "not a number", "finite numbers")
    return values
