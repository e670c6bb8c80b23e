"""What Drake's pendulums and capsules have in common: inertias, the simulator, and how it steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.multibody import tree
from pydrake.systems.analysis import Simulator

from plumbob.analytic.reference import Array

BROKEN = (OverflowError, ValueError, RuntimeError)  # raised where numbers are no longer finite


def spatial_inertia(mass: float, centre: Any, moments: Array) -> Any:
    """Of a body whose `moments` are about its `centre` of mass."""

    xx, yy, zz = np.diag(moments)
    about = tree.RotationalInertia(xx, yy, zz, moments[0, 1], moments[0, 2], moments[1, 2])
    return tree.SpatialInertia.MakeFromCentralInertia(mass, centre, about)


def simulator_of(diagram: Any, context: Any) -> Any:

    made = Simulator(diagram, context)
    made.set_target_realtime_rate(0.0)
    made.Initialize()
    return made


def advancing(simulator: Any, step: float) -> Callable[[int, int], None]:
    """What takes the steps with these indices, the last one excluded, of `step` [s]."""

    def advance(first: int, last: int) -> None:
        # A discrete update takes place at the time at which its step begins.
        simulator.AdvanceTo((last - 0.5) * step)

    return advance
