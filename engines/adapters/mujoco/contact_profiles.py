"""Contact profiles: what a MuJoCo model is told of its contacts, as data.

The convergent one, `coulomb`, is soft along the normal and hard across it. A contact there is an
explicit spring and damper, of frequency STIFFNESS/dt: the body sags by g (dt/STIFFNESS)^2 / 3, and
neither hops nor rings. Across, friction asks for rest within a step and yields a 1e-9th of what the
normal does. With the engine's defaults slip and normal force are coupled through the friction cone,
and a sliding body hops; smaller steps do not help.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.models.registry import unknown

STIFFNESS = 0.4  # natural frequency of a contact times the step; up to 0.41 no body rings on three
DAMPING = 0.3  # its damping ratio: 0.5 for the heave of a body on three
IMPEDANCE = 1e-4  # the least that MuJoCo takes: the normal's regularisation is 1e4 of its inertia
SOFTENING = 1e2  # and this times as much, set after compiling
GRIP = 1e9  # of the normal's regularisation over friction's
TOLERANCE = 1e-16  # of the solver: it costs hardly an iteration more than the 1e-8 as shipped

PairFields = Mapping[str, Any]
OWN_OPTIONS = ("cone", "impratio", "noslip_iterations")  # of a model's, those its contacts feel
OWN_ENDS = ("tolerance", "noslip_tolerance")  # of the solver, given beside the contacts


@dataclass(frozen=True)
class ContactProfile:
    """Options of the model, fields of every contact pair at a step [s], and the factor by which
    bodies in contact are to be taken for lighter than they are (`body_invweight0`)."""

    options: Mapping[str, Any] = field(default_factory=dict)
    pair: Callable[[float], PairFields] = lambda step: {}
    softening: float = 1.0

    def slip_compliance(self, step: float) -> float:
        """Speed of creep [m/s] per force at a contact [N], over the inverse weight [1/kg] of the
        body: what friction yields while it holds; 0 with noslip. Only for `coulomb`."""
        if self.options.get("noslip_iterations"):
            return 0.0
        part = self.softening / float(self.options["impratio"])
        return (1.0 - IMPEDANCE) / IMPEDANCE * part * step

    def coupling(self) -> float:
        """Change of a normal force [N] per change of slip speed in a step [m/s^2], over the weight
        [kg] and friction: what is left of the cone's coupling of the two. Only for `coulomb`."""
        return IMPEDANCE / (1.0 - IMPEDANCE) / self.softening

    def sag_compliance(self, step: float) -> float:
        """Depth [m] per normal force [N], over the inverse weight [1/kg]. Only for `coulomb`."""
        return (1.0 - IMPEDANCE) * (step / STIFFNESS) ** 2


def coulomb_pair(step: float, softening: float = SOFTENING) -> PairFields:
    """Fields of a contact pair at `step` [s] that make friction converge."""
    rate = STIFFNESS / step
    return {
        "solimp": np.array([IMPEDANCE, IMPEDANCE, 1e-3, 0.5, 2.0]),
        "solref": np.array([-(rate**2) * softening, -2 * DAMPING * rate * softening]),
        "solreffriction": np.array([-1.0, -IMPEDANCE / step]),
    }


_COULOMB = MappingProxyType(
    {"cone": "elliptic", "impratio": GRIP * SOFTENING, "tolerance": TOLERANCE}
)
_ELLIPTIC = MappingProxyType({"cone": "elliptic", "impratio": 100.0})
_NOSLIP = MappingProxyType({"noslip_iterations": 10})

PROFILES = MappingProxyType(
    {
        "default": ContactProfile(),
        "pyramidal": ContactProfile({"cone": "pyramidal", "impratio": 100.0}),
        "elliptic": ContactProfile(_ELLIPTIC),
        "elliptic+noslip": ContactProfile({**_ELLIPTIC, **_NOSLIP}),
        "coulomb": ContactProfile(_COULOMB, coulomb_pair, SOFTENING),
        "coulomb+noslip": ContactProfile(
            {**_COULOMB, **_NOSLIP, "noslip_tolerance": TOLERANCE / 100}, coulomb_pair, SOFTENING
        ),
    }
)


def profile(settings: Mapping[str, Any]) -> ContactProfile:
    """The contact profile that a method's settings name, or spell out as a mapping of fields of a
    contact, which no theory covers; raises ParameterError."""
    name = settings.get("contact", "default")
    if isinstance(name, Mapping):
        return _own(name, settings)
    if name not in PROFILES:
        raise ParameterError("contact", name, unknown(str(name), list(PROFILES)))
    return PROFILES[name]


def _own(contact: Mapping[str, Any], settings: Mapping[str, Any]) -> ContactProfile:
    """A user's contacts: fields of a contact, with the options of the model that they feel."""
    given = {name: settings[name] for name in OWN_OPTIONS if name in settings}
    ends = {name: contact[name] for name in OWN_ENDS if name in contact}
    fields = {name: value for name, value in contact.items() if name not in OWN_ENDS}
    if fields.get("condim") == 3:  # the scene's own, which is 1 where it has no friction
        del fields["condim"]
    return ContactProfile({**given, **ends}, lambda step: fields)


def convergent(settings: Mapping[str, Any]) -> bool:
    """Whether theory covers the profile that a method's settings name."""
    return profile(settings).softening != 1.0
