"""capsule-train in MuJoCo's terms: as every system of the capsule."""

from plumbob.engines.adapters.mujoco.capsule import build, regularisation, whole

__all__ = ["build", "regularisation", "whole"]
