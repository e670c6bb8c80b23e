"""The audit of a model of one's own from Python: a path, or a compiled model and its controls."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.analytic.reference import Array
from plumbob.engines.audit.audit import Audit, audited
from plumbob.engines.audit.controls import script
from plumbob.engines.own_motion import NotCertifiable
from plumbob.engines.registry import engines

BUDGET = 60.0  # [s] of wall time


def audit(
    model: Any,
    control: str | Array = "rest",
    *,
    keyframe: int | str | None = None,
    duration: float | None = None,
    period: float | None = None,
    budget: float = BUDGET,
) -> Audit:
    """How wrong `model`, a path to an MJCF file or a compiled `mujoco.MjModel`, is at its own
    integrator and step: its continuous motion is certified, and its steps are held against it.

    `control` is "rest", "zero", "sines" or values of shape (periods, actuators), held for `period`
    [s]; the motion lasts `duration` [s]; the whole takes about `budget` [s]. Raises ParameterError
    for bad input, and for a model that no reference can be certified for, with the reason.

    >>> import mujoco
    >>> rod = '''<mujoco><worldbody><body><joint axis="0 1 0"/>
    ...   <geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>'''
    >>> found = audit(mujoco.MjModel.from_xml_string(rod), duration=0.1, budget=5.0)
    >>> found.until, found.resolved
    (0.1, True)
    >>> found.assert_within(metres=0.01)
    """
    positive("budget", budget)
    name = str(model) if isinstance(model, (str, Path)) else "model"
    try:
        ready = engines()["mujoco"].own_model
        assert ready is not None
        own = ready(model, keyframe)
        moved = script(own, control, duration, period)
    except NotCertifiable as why:
        raise ParameterError("model", name, f"one that has a continuous motion; {why}") from None
    return audited(own, moved, control if isinstance(control, str) else "given", budget)
