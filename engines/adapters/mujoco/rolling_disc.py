"""The rolling disc in MuJoCo: slides, hinges whose angles are Euler's, and a contact."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from plumbob.analytic.errors.contact_models.disc_steps import ROLLS
from plumbob.analytic.schemes import Scheme
from plumbob.engines.adapters.mujoco import contacts
from plumbob.engines.adapters.mujoco.translation import (
    Translation,
    at_start,
    filled,
    set_contacts,
)
from plumbob.engines.method import Method
from plumbob.models.rolling_disc.model import MODEL


def scheme(method: Method) -> Scheme:
    """The scheme of `method` with its soft contacts, or with rolling for convergent contacts."""
    with_contact = contacts.scheme(method)
    return with_contact if with_contact.contact else replace(with_contact, contact=ROLLS)


def build(mjcf: Path, problem: Any, method: Method, step: float) -> Translation:
    """The translation of a RollingDisc, at about the static depth of its contact."""
    spec = filled(mjcf, MODEL, problem)
    profile = contacts.profile(method.settings, plane=True)
    set_contacts(spec, profile, step)
    if profile.convergent:
        spec.pair("contact").solref = spec.pair("contact").solref * (1.0 - contacts.IMPEDANCE)
        spec.key("start").qpos[2] -= problem.gravity * (step / contacts.STIFFNESS) ** 2
    return at_start(spec, tune=profile.soften)
