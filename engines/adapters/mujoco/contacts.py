"""Contact settings: profiles as data, and their record for theory. Needs no MuJoCo.

The convergent profile, `coulomb`, is soft along the normal and hard across it. A contact is then an
explicit spring and damper of natural frequency STIFFNESS/dt: its static penetration is at most
g (dt/STIFFNESS)^2 / 3, and it neither bounces nor rings. Across the normal, friction stops a slip
within a step, with a compliance 1e-9 of the normal's. With the engine's defaults the friction cone
couples slip to the normal force, and a sliding body chatters; smaller steps do not help.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType

import numpy as np

from plumbob.analytic.errors.contact_models.soft_contact import (
    NormalContact,
    SoftContact,
    without_formula,
)
from plumbob.analytic.errors.contact_models.soft_friction import Held, rates
from plumbob.analytic.errors.sliding_motion.plane_steps import FRICTION_LEADS
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import EULER, RK4, Scheme, SoftPoint
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.method import Method, ModelError, Options
from plumbob.models.registry import unknown
from plumbob.models.tripod_capsule.model import armature, tilt_inertia

# natural frequency of a contact times the step: a body on three is stable to 0.41
STIFFNESS = 0.4
DAMPING = 0.3  # its damping ratio: 0.5 for the vertical motion of a body on three
# the least that MuJoCo takes: the normal's regularisation is 1e4 of its inertia
IMPEDANCE = 1e-4
SOFTENING = 1e2  # a factor on that regularisation, set after compiling
PLANE_SOFTENING = 1e8  # the same in the plane: with 1e2, turns of epsilon 0.03 chatter
REGULARISATION_RATIO = 1e9  # of the normal's regularisation over friction's
TOLERANCE = 1e-16  # of the solver: takes barely more iterations than the default 1e-8

JOINT_IMPEDANCE = 0.9999  # of the reduced model's joint friction: the most that MuJoCo takes
JOINT_HARDENING = 1e-3  # a factor on what is left to 1, set after compiling
EXACT = 0.0  # solver tolerance of a single scalar constraint, solved by projection

SOLVED = 1e-8  # tolerance that MuJoCo's solver has by default
SETTLING = 4.0  # calibrated, of a part of a drift; tests/on_plane/test_held_bodies.py holds it
OVERSHOOT = 2.0  # calibrated: of a deflection with a damping ratio of 0.3

PairFields = Options
OWN_OPTIONS = (
    "cone",
    "impratio",
    "noslip_iterations",
)  # of a model: contacts depend on them
OWN_ENDS = ("tolerance", "noslip_tolerance")  # of the solver, given beside the contacts


@dataclass(frozen=True)
class ContactProfile:
    """Options of the model, fields of every contact pair at a step [s], and the factor by which
    the inverse weight of bodies in contact is overstated (`body_invweight0`)."""

    options: Options = field(default_factory=dict)
    pair: Callable[[float], PairFields] = lambda step: {}
    softening: float = 1.0
    soft: SoftPoint = field(default_factory=SoftPoint)  # of a profile that does not converge

    @property
    def convergent(self) -> bool:
        """Whether friction converges with the step, and theory covers it."""
        return self.softening != 1.0

    @property
    def point(self) -> SoftPoint | None:
        """A contact as theory takes it that is soft; None of a convergent profile."""
        if self.convergent:
            return None
        noslip = self.options.get("noslip_iterations")
        ratio = math.inf if noslip else float(self.options.get("impratio", 1.0))
        return replace(self.soft, ratio=ratio, pyramidal=self.options.get("cone") != "elliptic")

    def slip_compliance(self, step: float) -> float:
        """Drift [m/s] of a sticking contact per force on it [N], over the body's inverse weight
        [1/kg], at `step` [s]; 0 with noslip. Only for a convergent profile."""
        if self.options.get("noslip_iterations"):
            return 0.0
        part = self.softening / float(self.options["impratio"])
        return (1.0 - IMPEDANCE) / IMPEDANCE * part * step

    def coupling(self) -> float:
        """Change of a normal force [N] per slip acceleration [m/s^2], over the weight [kg] and the
        friction coefficient: the cone's coupling. Only for a convergent profile."""
        return IMPEDANCE / (1.0 - IMPEDANCE) / self.softening

    def pushed(self, friction: float, speed: float) -> float:
        """Error of a speed [m/s] by normal forces that follow a slip at `speed` [m/s] or less,
        until the deflection does. Only for a convergent profile."""
        return OVERSHOOT * friction**2 * self.coupling() * speed / STIFFNESS

    def depth(self, held: Held, step: float) -> float:
        """Depth [m] at which a contact rests at `step` [s]."""
        if self.convergent:
            return self.compliance(step) * held.load * held.weight
        return held.depth(self.point or SoftPoint(), step)

    def compliance(self, step: float) -> float:
        """Deflection [m] per normal force [N], over the inverse weight [1/kg], at `step` [s]. Only
        for a convergent profile."""
        return (1.0 - IMPEDANCE) * (step / STIFFNESS) ** 2


def coulomb_pair(
    step: float, softening: float = SOFTENING, lead: float = 1.0, stiffness: float = STIFFNESS
) -> PairFields:
    """Fields of a contact pair at `step` [s] that make friction converge: it stops a slip within
    the part `lead` of a step; its natural frequency times the step is `stiffness`."""
    rate = stiffness / step
    return {
        "solimp": np.array([IMPEDANCE, IMPEDANCE, 1e-3, 0.5, 2.0]),
        "solref": np.array([-(rate**2) * softening, -2 * DAMPING * rate * softening]),
        "solreffriction": np.array([-1.0, -(1.0 / lead) * IMPEDANCE / step]),
    }


def stiff_pair(step: float) -> PairFields:
    """Fields of a contact pair at `step` [s] that is as stiff as MuJoCo takes it."""
    return {
        "solref": np.array([2.0 * step, 1.0]),
        "solimp": np.array([*_STIFF.impedance, 1e-3, 0.5, 2.0]),
    }


_COULOMB = MappingProxyType(
    {"cone": "elliptic", "impratio": REGULARISATION_RATIO * SOFTENING, "tolerance": TOLERANCE}
)
_ELLIPTIC = MappingProxyType({"cone": "elliptic", "impratio": 100.0})
_NOSLIP = MappingProxyType({"noslip_iterations": 10})

_STIFF = SoftPoint(time_constant=0.0, impedance=(0.9999, 0.9999))
"""The stiffest that MuJoCo takes: a time constant of two steps, and the largest impedance."""

PROFILES = MappingProxyType(
    {
        "default": ContactProfile(),
        "stiff": ContactProfile(
            {"cone": "elliptic", "tolerance": TOLERANCE}, stiff_pair, soft=_STIFF
        ),
        "pyramidal": ContactProfile({"cone": "pyramidal", "impratio": 100.0}),
        "elliptic": ContactProfile(_ELLIPTIC),
        "elliptic+noslip": ContactProfile({**_ELLIPTIC, **_NOSLIP}),
        "coulomb": ContactProfile(_COULOMB, coulomb_pair, SOFTENING),
        "coulomb+noslip": ContactProfile(
            {**_COULOMB, **_NOSLIP, "noslip_tolerance": TOLERANCE / 100},
            coulomb_pair,
            SOFTENING,
        ),
    }
)


def profile(settings: Options, plane: bool = False) -> ContactProfile:
    """The contact profile that a method's settings name, or spell out as a mapping, or pairs, of
    fields of a contact, which no theory covers; raises ParameterError.

    For motion in the `plane` convergent profiles are softened further, for the coupling of slip to
    a normal force goes as slip speed over step; and friction stops a slip within half a step of
    RK4, whose stages apply it half a step late.
    """
    name = settings.get("contact", "default")
    if isinstance(name, Mapping | tuple):
        return _own(dict(name), settings)
    if name not in PROFILES:
        raise ParameterError("contact", name, unknown(str(name), list(PROFILES)))
    chosen = PROFILES[name]
    lead = FRICTION_LEADS[integrator_of(settings)]
    if not (plane and chosen.convergent):
        return chosen
    return replace(
        chosen,
        options={**chosen.options, "impratio": REGULARISATION_RATIO * PLANE_SOFTENING},
        pair=partial(coulomb_pair, softening=PLANE_SOFTENING, lead=lead),
        softening=PLANE_SOFTENING,
    )


def _own(contact: Options, settings: Options) -> ContactProfile:
    """A user's contacts: fields of a contact, with the options of the model that affect them."""
    options = {name: settings[name] for name in OWN_OPTIONS if name in settings}
    ends = {name: contact[name] for name in OWN_ENDS if name in contact}
    fields = {name: value for name, value in contact.items() if name not in OWN_ENDS}
    if fields.get("condim") == 3:  # the scene's own, which is 1 where it has no friction
        del fields["condim"]
    return ContactProfile({**options, **ends}, lambda step: fields)


def contacts(problem: CapsuleProblem, settings: Options) -> ContactProfile:
    """The profile that `settings` name; raises ParameterError."""
    return profile(settings, plane=without_formula(problem))


def scheme(method: Method) -> Scheme:
    """The scheme of `method` on bodies that touch: with its soft contacts; no theory covers those
    of a user's own."""
    if not isinstance(method.settings.get("contact", ""), str):
        return Scheme("contacts of a file")
    return replace(method.scheme, contact=profile(method.settings).point)


def drift_error(
    point: SoftPoint, held: Held, duration: float, step: float, inertia: float
) -> ModelError:
    """Bounds on way and speed of what drifts: the solver leaves an acceleration at each step, with
    the `inertia` of all coordinates over the body's, which the contact's damping forgets; as it
    does what normal forces that settle change of the drift."""
    damping = rates(point, step)[1]
    left = math.sqrt(2.0 * inertia * SOLVED) / damping
    slow = 0.0
    if held.holds(point):
        slow = (
            SETTLING * held.settling(point, step) * float(np.hypot(*held.drift(point, step)[0]))
        )
    return {
        "x": {"solver": left * duration, "settling": slow / damping},
        "speed": {"solver": left, "settling": slow},
    }


def soft_contact(problem: CapsuleProblem, settings: Options, step: float) -> SoftContact | None:
    """The record of contacts, or of joint friction, at `step` [s] that theory takes; None where no
    theory covers them; raises ParameterError."""
    setup = problem.setup
    model = settings.get("model", "full")
    both = setup.capsule.body_mass + setup.capsule.slider_mass
    if model == "reduced":
        drift = (1.0 - JOINT_IMPEDANCE) / JOINT_IMPEDANCE * JOINT_HARDENING * step
        held = SoftContact(step, drift / both, EXACT, armature(setup))
        return None if without_formula(problem) else held
    chosen = contacts(problem, settings)
    if not chosen.convergent:
        return None
    normal = NormalContact(
        compliance=chosen.compliance(step) / both,
        coupling=chosen.coupling() * both,
        frequency_step=STIFFNESS,
        damping_ratio=DAMPING,
        tilt_inertia=tilt_inertia(problem),
        height=float(settings.get("height", 0.0)),
    )
    tolerance = float(chosen.options["tolerance"])
    slip = chosen.slip_compliance(step) / both
    return SoftContact(step, slip, tolerance, armature(setup), normal, integrator_of(settings))


def integrator_of(settings: Options) -> str:
    """The integrator that theory takes: RK4, or Euler for every other one of MuJoCo's."""
    return RK4 if settings.get("integrator") == "RK4" else EULER
