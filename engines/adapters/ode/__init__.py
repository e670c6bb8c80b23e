"""ODE solvers as an engine: the same scenes as an equation of motion, the reference_steps."""

from __future__ import annotations

from collections.abc import Mapping

from plumbob.engines.adapters.ode.methods import METHODS
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import Case


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Set up `case` for `method` at `step` [s], or at the relative tolerance `step`; raises
    Unsupported and ParameterError."""
    from plumbob.engines.adapters.ode.simulation import prepared

    return prepared(case, method, step)


def model_error(case: Case, method: Method, step: float) -> Mapping[str, Mapping[str, float]]:
    """Nothing: an equation of motion is the system itself."""
    return {}


ENGINE = Engine("ode", "scipy", METHODS, prepare, model_error)
