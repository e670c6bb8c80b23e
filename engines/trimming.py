"""What an engine leaves out of a model, what that saves, and whether the motion stays the same."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Trimming:
    """Cost of a step of three versions of one model: complete, with the pipeline stages disabled
    that have nothing to do in it, and as it is run, without the parts that have no effect too."""

    ns_default: float  # the complete model [ns of processor time per step]
    ns_flags: float  # needless stages disabled [ns]
    ns_trimmed: float  # as run [ns]
    identical: bool  # whether the three states at the end agree to the last bit
    stages_off: tuple[str, ...] = ()  # names of the disabled pipeline stages
    parts_left_out: tuple[str, ...] = ()  # counts with their words: "2 geoms", "1 mesh"

    @property
    def saved(self) -> float:
        """Fraction of the complete model's cost that is saved."""
        return 1.0 - self.ns_trimmed / self.ns_default
