"""The relation of a free body to free_body.xml."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from plumbob.analytic.reference import Array, Signals
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES
from plumbob.models.largest import DIVERGED_RATIO
from plumbob.models.model_file import ModelFile


def fill(spec: Any, body: FreeBody) -> None:
    """Writes the numbers of a free body into an MjSpec of free_body.xml."""
    spec.body("body").inertia = list(body.inertia)
    spec.key("start").qvel = [0.0, 0.0, 0.0, *body.angular_velocity]


def observe(body: FreeBody, qpos: Array, qvel: Array) -> Signals:
    """Returns the attitude, and the angular velocity in the body's axes."""
    attitude = dict(zip(ATTITUDE, qpos[:, 3:7].T, strict=True))
    return attitude | dict(zip(RATES, qvel[:, 3:6].T, strict=True))


def largest(body: FreeBody) -> Mapping[str, float]:
    """Returns angular velocities [rad/s] that no motion reaches."""
    return dict.fromkeys(RATES, DIVERGED_RATIO * body.fastest or 1.0)


MODEL = ModelFile(fill, observe, largest=largest)
