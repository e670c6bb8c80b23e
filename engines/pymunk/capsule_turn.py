"""capsule-turn in pymunk's terms: as every system of the capsule."""

from engines.pymunk.capsule import build, regularisation

__all__ = ["build", "regularisation"]
