"""What leaving out a model's idle stages and parts saves, as an engine measures it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Trimming:
    """Cost of a step [ns] of a model with everything in, without idle stages, and as run, which
    leaves out parts too; whether the motion is the same; and what was left out."""

    ns_default: float
    ns_flags: float
    ns_trimmed: float
    identical: bool  # all three states at the end agree to the last bit
    stages_off: tuple[str, ...] = ()  # the engine's names of pipeline stages, idle in this scene
    parts_left_out: tuple[str, ...] = ()  # seen and not felt: "3 geoms", "1 mesh"
