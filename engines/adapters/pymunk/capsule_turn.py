"""capsule-turn in pymunk's terms: as every system of the capsule."""

from plumbob.engines.adapters.pymunk.capsule import build, regularisation

__all__ = ["build", "regularisation"]
