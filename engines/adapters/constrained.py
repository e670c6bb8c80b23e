"""The scheme of engines that build mechanisms, on cases with contacts or rigid loops."""

from __future__ import annotations

from plumbob.analytic.schemes import Scheme
from plumbob.engines.method import Method
from plumbob.models.idealisations import NO_IDEALISATIONS
from plumbob.models.scene import ON_PLANE, ON_SUPPORTS, Case

# Scheme of steps that solve for contacts or loops, which no theory here covers
CONSTRAINED = Scheme("euler with constraints")
DISC = "rolling-disc"  # name of a smooth system whose body touches the ground


def constrained(case: Case) -> bool:
    """Whether bodies of a case touch, or the case's mechanism has a rigid loop."""
    system = case.system
    ideal = (
        NO_IDEALISATIONS if system.model_file is None else system.model_file.ideal(case.problem)
    )
    loops = bool(ideal.rigid_loops)
    return loops or system.kind in (ON_PLANE, ON_SUPPORTS) or system.name == DISC


def scheme_unless_constrained(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on a case: its own or, if bodies touch or a loop is closed, a scheme
    that no theory covers."""
    return CONSTRAINED if constrained(case) else method.scheme
