"""The capsule seen from above on bare pivots, one a support: friction that does not converge.

The naive way, here to be measured: the solver clamps the impulse that would bring the support to
rest, which on a rigid body off its centre is not along the support's velocity. No step and no
number of sweeps mends it.
"""

from __future__ import annotations

from dataclasses import replace

from plumbob.analytic.systems.capsule_setup import CapsuleSetup
from plumbob.engines.adapters.pymunk.capsule_space import Assembly, assembled, gripped


def pivots(setup: CapsuleSetup, step: float) -> Assembly:
    """The capsule on three joints to the ground; what friction can at each is yet to be told."""
    capsule = setup.capsule
    bare = assembled(setup, capsule.body_mass, capsule.inertia, 0j, step)
    grips = tuple(gripped(bare.space, bare.body, complex(x, y)) for x, y in capsule.supports)
    bare.space.add(*grips)
    return replace(bare, grips=grips)
