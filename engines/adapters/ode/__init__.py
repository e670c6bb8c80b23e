"""ODE solvers as an engine: the same scenes as an equation of motion, the yardsticks."""

from __future__ import annotations

from collections.abc import Mapping

from plumbob.engines.adapters.ode.methods import METHODS
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.models.scene import Scene, System


def prepare(system: System, scene: Scene, method: Method, step: float) -> Simulation:
    """Set up `scene` for `method` at `step` [s], or at the relative tolerance `step`; raises
    Unsupported and ParameterError."""
    from plumbob.engines.adapters.ode.simulation import prepared

    return prepared(system, scene, method, step)


def regularisation(
    system: System, scene: Scene, method: Method, step: float
) -> Mapping[str, Mapping[str, float]]:
    """Nothing: an equation of motion is the system itself."""
    return {}


ENGINE = Engine("ode", "scipy", METHODS, prepare, regularisation)
