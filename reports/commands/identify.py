"""plumbob identify: the parameters with which an engine's run fits the exact motion best."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from plumbob.analytic.parameters import ParameterError, nearest
from plumbob.engines.registry import method as find_method
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.values import default_step

if TYPE_CHECKING:
    from plumbob.engines.box import Side
    from plumbob.engines.study.identification import Identification
    from plumbob.models.scene import Case

BUDGET = 100  # runs for each parameter


def command(chosen: argparse.Namespace) -> int:
    """Search, print what fits best beside what is true."""
    from plumbob.engines.box import box
    from plumbob.engines.study.identification import identify
    from plumbob.engines.sweep.sweep import runnable
    from plumbob.reports.commands.arguments.console import progress

    method = find_method(chosen.method)
    changed = chosen.changes
    step = chosen.step or default_step(method)
    with values.representable(changed):
        true = case_of(find_scene(chosen.scene, changed))
        sides = list(_sides(true, chosen))
        sought = [limits.name for limits in sides]
        around = box(chosen.scene, {n: v for n, v in changed.items() if n not in sought}, sides)
    runnable(around, [method])
    with progress() as show:
        fit = identify(
            around,
            true,
            method,
            step,
            chosen.budget or len(sides) * BUDGET,
            chosen.all_samples,
            chosen.noise,
            chosen.seed,
            lambda made, of, residual: show(f"residual so far {residual:.3g}", made, of),
            chosen.way,
        )
    values.show(chosen, records(fit), "identify", found=fit, control=method.control)
    return 0


def records(fit: Identification) -> list[dict[str, Any]]:
    """One record for each parameter."""
    apart = ("parameters", "low", "high")
    return [
        {name: value for name, value in (vars(fit) | vars(of)).items() if name not in apart}
        | {"within": [of.low, of.high], "at_an_end": of.at_an_end}
        for of in fit.parameters
    ]


def _sides(true: Case, chosen: argparse.Namespace) -> Iterator[Side]:
    """The parameters that are searched for, each from half of its value to twice it unless another
    interval is given; raises ParameterError."""
    from plumbob.engines.box import Side

    limits = {side.name: side for side in chosen.within}
    wanted = dict.fromkeys(name.strip() for name in chosen.parameter.split(","))
    allowed = true.system.parameters
    if wrong := next((name for name in wanted if name not in allowed), None):
        raise ParameterError("parameter", wrong, f"one of {nearest(wrong, list(allowed))}")
    for name in limits.keys() - wanted:
        raise ParameterError("within", name, f"one of {', '.join(wanted)}")
    for name in wanted:
        value = true.scene.parameters.get(name, true.system.left_out.get(name, 0.0))
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(
                "parameter", name, f"a parameter with one number, not {value!r}"
            )
        ends = sorted((value / 2, value * 2)) if value else (-1.0, 1.0)
        yield limits.get(name) or Side(name, *ends)
