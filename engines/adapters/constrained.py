"""Cases in which an engine that builds mechanisms has more to solve than a tree of joints."""

from __future__ import annotations

from plumbob.analytic.schemes import Scheme
from plumbob.models.idealisations import NONE
from plumbob.models.scene import ON_PLANE, ON_SUPPORTS, Case

CONSTRAINED = Scheme(
    "euler with constraints"
)  # velocities are constrained, which no theory here covers
DISC = "rolling-disc"  # a smooth system whose body touches the ground


def constrained(case: Case) -> bool:
    """Whether bodies of a case touch, or its mechanism has a rigid loop."""
    system = case.system
    ideal = NONE if system.model_file is None else system.model_file.ideal(case.problem)
    loops = bool(ideal.rigid_loops)
    return loops or system.kind in (ON_PLANE, ON_SUPPORTS) or system.name == DISC
