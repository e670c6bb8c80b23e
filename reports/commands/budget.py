"""The processor time that the exact motion of a scene may take before a command uses it."""

from __future__ import annotations

import time

from plumbob.analytic.parameters import ParameterError
from plumbob.models.scene import Case


def certify(case: Case, last: float, seconds: float) -> None:
    """Integrate the exact motion of a `case` up to `last` [s], if it is known by integration alone:
    the motion is kept for later use. Raises ParameterError if that takes more than `seconds` of
    processor time."""
    from plumbob.reports.commands.validate import progress

    integrate = getattr(case.reference, "certify", None)
    if integrate is None:
        return
    begin = time.process_time()
    with progress() as show:

        def watch(reached: float) -> None:
            spent = time.process_time() - begin
            known = f"certified up to t = {reached:.4g} of {last:.4g} s"
            if spent > seconds:
                wanted = f"more: the exact motion is {known} within {seconds:g} s"
                raise ParameterError("budget", seconds, f"{wanted} of processor time")
            show(known, int(spent), int(seconds))

        integrate(last, watch)
