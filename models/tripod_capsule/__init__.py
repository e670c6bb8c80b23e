"""The capsule on three supports with a moving mass inside: its systems, with their scenes as
data."""

from __future__ import annotations

from plumbob.models.tripod_capsule import coast, hold, line, plan, repeated, turn

SYSTEMS = (
    line.SYSTEM,
    turn.SYSTEM,
    hold.SYSTEM,
    coast.SYSTEM,
    repeated.SYSTEM,
    plan.SYSTEM,
)
