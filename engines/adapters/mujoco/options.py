"""A method's settings on a model yet to be compiled: integrator, cone, solver, tolerances."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco

from plumbob.analytic.parameters import ParameterError

# option -> its enumeration and the prefix of that enumeration's names
CHOICES: tuple[tuple[str, type[Any], str], ...] = (
    ("integrator", mujoco.mjtIntegrator, "mjINT_"),
    ("cone", mujoco.mjtCone, "mjCONE_"),
    ("solver", mujoco.mjtSolver, "mjSOL_"),
    ("jacobian", mujoco.mjtJacobian, "mjJAC_"),
)
ELSEWHERE = (
    "contact",
    "control_at",
    "height",
    "model",
)  # settings that builders and runs read, and no option


def apply(spec: mujoco.MjSpec, settings: Mapping[str, Any], step: float) -> None:
    """Set `step` [s] and the options named in `settings` on `spec`; raises ParameterError."""
    spec.option.timestep = step
    choices = {option: (kind, prefix) for option, kind, prefix in CHOICES}
    for option, value in settings.items():
        if option in ELSEWHERE:
            continue
        if option not in choices:
            if not hasattr(spec.option, option):
                raise ParameterError(option, value, "an option that MuJoCo has")
            setattr(spec.option, option, value)
            continue
        kind, prefix = choices[option]
        if (chosen := kind.__members__.get(prefix + str(value).upper())) is None:
            known = (name.removeprefix(prefix).lower() for name in kind.__members__)
            raise ParameterError(option, value, f"one of {', '.join(known)}")
        setattr(spec.option, option, int(chosen))
