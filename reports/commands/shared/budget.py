"""The processor time that a command may spend on the exact motion of a scene."""

from __future__ import annotations

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.exact_budget import integrated
from plumbob.models.scene import Case


def certify(case: Case, last: float, budget: float, fraction: float = 1.0) -> None:
    """Integrates the exact motion of `case` up to the time `last` [s], if only integration gives
    it. The motion is kept for later use. Raises ParameterError if the integration takes more than
    the `fraction` of the `budget` [s] of processor time."""
    from plumbob.reports.commands.arguments.console import progress

    allowed_seconds = fraction * budget

    def certified_range(end: float) -> str:
        return f"certified up to t = {end:.4g} of {last:.4g} s"

    with progress() as show:

        def show_range(end: float, used_seconds: float) -> None:
            show(certified_range(end), int(used_seconds), int(allowed_seconds))

        certified_until = integrated(case, last, allowed_seconds, show_range)
    if certified_until < last:
        wanted = f"more: the exact motion is {certified_range(certified_until)}"
        raise ParameterError(
            "budget", budget, f"{wanted} within {allowed_seconds:g} s of processor time"
        )
