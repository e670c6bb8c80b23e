"""The capsule in MuJoCo's terms: what the builders of its systems share."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import mujoco
import numpy as np

from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.adapters.mujoco import capsule_plane_shares, capsule_reduced, capsule_shares
from plumbob.engines.adapters.mujoco.capsule_control import control
from plumbob.engines.adapters.mujoco.capsule_coordinates import along, plane, start
from plumbob.engines.adapters.mujoco.capsule_forces import reading
from plumbob.engines.adapters.mujoco.capsule_model import contacts, off_line, whole
from plumbob.engines.adapters.mujoco.capsule_rest import SHIPPED_STEP, settled
from plumbob.engines.adapters.mujoco.contact_profiles import convergent
from plumbob.engines.adapters.mujoco.translation import Translation
from plumbob.engines.method import Method

# One body on one plane: nothing to find by looking for islands of contacts.
ISLANDS = int(mujoco.mjtDisableBit.mjDSBL_ISLAND)
FAR = 1e3  # of its own sizes: no body that only slides gets there

__all__ = ["build", "model_error", "whole"]


def build(mjcf: Path, problem: CapsuleProblem, method: Method, step: float) -> Translation:
    """Translate a capsule's problem, in the model that the method's settings name: the full one
    with a free joint, `planar`, or `reduced` to one line; raises Unsupported."""
    model = method.settings.get("model", "full")
    if model == "reduced":
        return capsule_reduced.build(mjcf.with_name("reduced.xml"), problem, step)
    file = mjcf.with_name("planar.xml") if model == "planar" else mjcf
    setup, chosen = problem.setup, contacts(problem, method.settings)
    spec = whole(file, problem, method.settings, step)
    seen = spec.copy()
    for shown in [geom for geom in spec.geoms if geom.classname.name == "visual"]:
        spec.delete(shown)  # seen, not felt: without them a step costs less
    spec.option.disableflags |= ISLANDS

    def tune(compiled: mujoco.MjModel) -> None:
        compiled.body_invweight0[compiled.body("body").id] *= chosen.softening

    settling = step if convergent(method.settings) else SHIPPED_STEP
    rest = settled(spec, tune, setup.press, settling)
    qpos, qvel = start(setup, rest)
    size = float(np.abs(setup.capsule.supports).max())
    return Translation(
        spec,
        qpos=qpos,
        qvel=qvel,
        observe=(plane if setup.in_plane else along)(setup, rest),
        limits=dict.fromkeys(("displacement", "x", "y"), FAR * size),
        control=control(setup, step),
        whole=seen,
        probe=reading(setup),
        tune=tune,
    )


def model_error(
    problem: CapsuleProblem, duration: float, method: Method, step: float
) -> Mapping[str, Mapping[str, float]]:
    """What the model adds to each observable, by reason, where its contacts are such that theory
    covers them."""
    if not off_line(problem):
        return capsule_shares.shares(problem, duration, method.settings, step)
    if not convergent(method.settings):
        return {}
    chosen = contacts(problem, method.settings)
    return capsule_plane_shares.shares(problem, duration, chosen, step)
