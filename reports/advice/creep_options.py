"""Advice on the options that stop the creep of bodies that friction should hold."""

from __future__ import annotations

import math
from collections.abc import Sequence

from plumbob.engines.own_holds import FrictionOptions

SPARE = 1.5  # factor by which the predicted creep is below what is asked for
FIRST_DIGITS = (1.0, 2.0, 5.0, 10.0)
# Largest impratio that is advised without noslip. Beyond it the solver's default tolerance of 1e-8
# leaves more slip than friction does.
MOST_IMPRATIO = 1e6
LESS = 10.0  # factor by which a second attempt raises impratio
NOSLIP = 10  # iterations of noslip that the last attempt adds


def rounded_up(value: float) -> float:
    """Returns the next of 1, 2, 5, 10, 20, ... that is not below a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(power * d for d in FIRST_DIGITS if power * d >= value * (1.0 - 1e-9))


def options_text(own: FrictionOptions, options: FrictionOptions) -> str:
    """Returns the element <option> that changes a model's `own` options into others."""
    changed = {
        name: value for name, value in vars(options).items() if value != getattr(own, name)
    }
    written = (
        f'{name}="{value if isinstance(value, str) else format(value, "g")}"'
        for name, value in changed.items()
    )
    return f"<option {' '.join(written)}/>"


def creep_options(
    own: FrictionOptions, rigid_creep: float | None, wanted: float
) -> Sequence[FrictionOptions]:
    """Returns options to try against creep, the ones with the fewest side effects first.

    `own` are the model's options, `rigid_creep` is the predicted creep [m/s] of elliptic cones with
    impratio 1, which falls as 1/impratio, and `wanted` is the largest creep [m/s] that is asked
    for. Elliptic cones come first: pyramids creep faster and hold less along their diagonals."""
    needed = SPARE * rigid_creep / wanted if rigid_creep else 1.0
    ratio = min(rounded_up(max(needed, own.impratio, 1.0)), MOST_IMPRATIO)
    ratios = sorted({ratio, min(LESS * ratio, MOST_IMPRATIO)})
    options = [FrictionOptions("elliptic", ratio, own.noslip_iterations) for ratio in ratios]
    return [*options, FrictionOptions("elliptic", ratio, max(NOSLIP, own.noslip_iterations))]
