"""The processor time that the exact motion of a scene may take before a command uses it."""

from __future__ import annotations

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.exact_budget import integrated
from plumbob.models.scene import Case


def certify(case: Case, last: float, budget: float, fraction: float = 1.0) -> None:
    """Integrate the exact motion of a `case` up to `last` [s], if it is known by integration alone:
    the motion is kept for later use. Raises ParameterError if that takes more than a `fraction` of
    the `budget` [s] of processor time."""
    from plumbob.reports.commands.arguments.console import progress

    seconds = fraction * budget

    def known(reached: float) -> str:
        return f"certified up to t = {reached:.4g} of {last:.4g} s"

    with progress() as show:
        until = integrated(
            case,
            last,
            seconds,
            lambda reached, spent: show(known(reached), int(spent), int(seconds)),
        )
    if until < last:
        wanted = f"more: the exact motion is {known(until)} within {seconds:g} s"
        raise ParameterError("budget", budget, f"{wanted} of processor time")
