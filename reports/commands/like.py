"""What `--like` takes: a user's model file, and what its settings are held against by default."""

from __future__ import annotations

import argparse

from analytic.parameters import ParameterError
from engines.method import Method
from engines.mujoco.like import NAME, mine
from engines.registry import engines, installed

# A line at four headings is the quickest way to tell what a setting's friction is worth.
SCENES = ",".join(("*", *(f"capsule-line/heading-{angle:03d}" for angle in (0, 30, 45, 90))))
METHODS = ",".join((
    "mujoco/euler", "mujoco/implicitfast", "mujoco/rk4", "mujoco/rk4+midpoint",
    "mujoco/euler+elliptic+noslip", "mujoco/euler+coulomb", "mujoco/euler+reduced", "pymunk",
    "ode/leapfrog", "ode/rk4",
))  # fmt: skip


def add_like(parser: argparse.ArgumentParser) -> None:
    """Let a command take --like."""
    parser.add_argument(
        "--like", metavar="FILE",
        help=f"measure the options and contact defaults of your own MJCF file too, as {NAME}; "
        "whatever comes of them is reported, and is no failure",
    )  # fmt: skip


def own_method(path: str) -> Method:
    """The method that the settings in the file `path` are; raises ParameterError."""
    if not installed(engines()["mujoco"]):
        raise ParameterError("like", path, "measured with MuJoCo, which is not installed")
    return mine(path)
