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

BUDGET = 100  # number of runs for each parameter


def command(chosen: argparse.Namespace) -> int:
    """Searches for the parameters that fit best, and prints them beside the true values."""
    from plumbob.engines.box import box
    from plumbob.engines.study.identification import identify
    from plumbob.engines.sweep.sweep import runnable
    from plumbob.reports.commands.arguments.console import progress

    method = find_method(chosen.method)
    changed = chosen.changes
    step = chosen.step or default_step(method)
    with values.representable(changed):
        true_case = case_of(find_scene(chosen.scene, changed))
        sides = list(_sides(true_case, chosen))
        searched = [side.name for side in sides]
        fixed = {name: value for name, value in changed.items() if name not in searched}
        search_box = box(chosen.scene, fixed, sides)
    runnable(search_box, [method])
    with progress() as show:

        def show_residual(runs: int, budget: int, residual: float) -> None:
            show(f"residual so far {residual:.3g}", runs, budget)

        fit = identify(
            box=search_box,
            known=true_case,
            method=method,
            step=step,
            budget=chosen.budget or len(sides) * BUDGET,
            all_samples=chosen.all_samples,
            noise=chosen.noise,
            seed=chosen.seed,
            progress=show_residual,
            way=chosen.way,
        )
    values.show(chosen, records(fit), "identify", found=fit, control=method.control)
    return 0


def records(fit: Identification) -> list[dict[str, Any]]:
    """Returns one record for each parameter."""
    result = []
    for parameter in fit.parameters:
        record = vars(fit) | vars(parameter)
        for name in ("parameters", "low", "high"):
            del record[name]
        record["within"] = [parameter.low, parameter.high]
        record["at_an_end"] = parameter.at_an_end
        result.append(record)
    return result


def _sides(true_case: Case, chosen: argparse.Namespace) -> Iterator[Side]:
    """Gives the interval in which each parameter is searched for: the interval that the user gives,
    else half to twice the true value. Raises ParameterError."""
    from plumbob.engines.box import Side

    given = {side.name: side for side in chosen.within}
    wanted = dict.fromkeys(name.strip() for name in chosen.parameter.split(","))
    allowed = true_case.system.parameters
    for name in wanted:
        if name not in allowed:
            raise ParameterError("parameter", name, f"one of {nearest(name, list(allowed))}")
    for name in given.keys() - wanted:
        raise ParameterError("within", name, f"one of {', '.join(wanted)}")
    for name in wanted:
        default = true_case.system.left_out.get(name, 0.0)
        value = true_case.scene.parameters.get(name, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(
                "parameter", name, f"a parameter with one number, not {value!r}"
            )
        ends = sorted((value / 2, value * 2)) if value else (-1.0, 1.0)
        yield given.get(name) or Side(name, *ends)
