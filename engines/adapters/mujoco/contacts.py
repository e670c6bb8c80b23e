"""Contact settings of methods: profiles as data, and their records for theory. Needs no MuJoCo.

The convergent profile, `coulomb`, is soft vertically and stiff sideways. Along the normal a contact
is an explicit spring and damper with natural frequency STIFFNESS/dt: its static penetration is at
most g (dt/STIFFNESS)^2 / 3, and it neither bounces nor rings. Along the surface, friction stops a
slip within a step, with a compliance 1e-9 times the normal compliance. With MuJoCo's default
contacts the friction cone couples slip to the normal force: a sliding body chatters at every step
size."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from plumbob.analytic.errors.contact_models.soft_contact import (
    NormalContact,
    SoftContact,
    without_formula,
)
from plumbob.analytic.errors.contact_models.soft_friction import HeldContact, rates
from plumbob.analytic.errors.sliding_motion.plane_steps import FRICTION_LEADS
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import EULER, RK4, Scheme, SoftPoint
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.method import Method, ModelError, Options
from plumbob.models.registry import unknown
from plumbob.models.tripod_capsule.model import armature, tilt_inertia

# Natural frequency of a contact times the step: a body on three contacts is stable up to 0.41
STIFFNESS = 0.4
DAMPING = 0.3  # damping ratio of a contact; 0.5 for the vertical motion of a body on three
# Smallest impedance that MuJoCo allows: the normal's regularisation is 1e4 times its inertia
IMPEDANCE = 1e-4
SOFTENING = 1e2  # factor on that regularisation, set after compiling
PLANE_SOFTENING = 1e8  # the same factor for motion in the plane: with 1e2 slow turns chatter
REGULARISATION_RATIO = 1e9  # ratio of the normal's regularisation to friction's
TOLERANCE = 1e-16  # solver's tolerance: needs barely more iterations than the default 1e-8

# Largest impedance that MuJoCo allows, for the reduced model's friction
JOINT_IMPEDANCE = 0.9999
JOINT_HARDENING = 1e-3  # factor on 1 - JOINT_IMPEDANCE, set after compiling
EXACT = 0.0  # solver's tolerance for a single scalar constraint, which is solved exactly

SOLVED = 1e-8  # default tolerance of MuJoCo's solver
SETTLING = 4.0  # calibrated factor on a part of a drift: tests/on_plane/test_held_bodies.py
OVERSHOOT = 2.0  # calibrated factor on a deflection with a damping ratio of 0.3

PairFields = Options
# Options of a model that change contacts
OWN_OPTIONS = (
    "cone",
    "impratio",
    "noslip_iterations",
)
# Tolerances of the solver, which a user's settings have among the fields of contacts
OWN_TOLERANCES = ("tolerance", "noslip_tolerance")


@dataclass(frozen=True)
class ContactProfile:
    """Settings of contacts, and what theory needs of them."""

    options: Options = field(default_factory=dict)  # options of the model
    # step [s] -> fields of a contact pair
    pair: Callable[[float], PairFields] = lambda step: {}
    softening: float = 1.0
    """Factor by which `body_invweight0` of bodies in contact is overstated."""
    soft: SoftPoint = field(default_factory=SoftPoint)  # the contact, if it does not converge

    @property
    def convergent(self) -> bool:
        """Whether friction converges with the step, and theory covers it."""
        return self.softening != 1.0

    def soften(self, model: Any) -> None:
        """Overstates the inverse weights of a compiled model's bodies, which no file can."""
        model.body_invweight0 *= self.softening

    @property
    def point(self) -> SoftPoint | None:
        """The record of a soft contact for theory; None if the profile converges."""
        if self.convergent:
            return None
        noslip = self.options.get("noslip_iterations")
        ratio = math.inf if noslip else float(self.options.get("impratio", 1.0))
        return replace(self.soft, ratio=ratio, pyramidal=self.options.get("cone") != "elliptic")

    def slip_compliance(self, step: float) -> float:
        """The drift [m/s] of a sticking contact per force [N] and inverse weight [1/kg], at `step`
        [s]; 0 with noslip. For convergent profiles only."""
        if self.options.get("noslip_iterations"):
            return 0.0
        friction_softening = self.softening / float(self.options["impratio"])
        return (1.0 - IMPEDANCE) / IMPEDANCE * friction_softening * step

    def coupling(self) -> float:
        """The coupling by the cone: the change of a normal force [N] per slip acceleration [m/s^2],
        weight [kg] and friction coefficient. For convergent profiles only."""
        return IMPEDANCE / (1.0 - IMPEDANCE) / self.softening

    def pushed(self, friction: float, speed: float) -> float:
        """The bound on the error of a speed [m/s] from normal forces that change with a slip of at
        most `speed` [m/s], until the deflection of the contact has followed. For convergent
        profiles only."""
        return OVERSHOOT * friction**2 * self.coupling() * speed / STIFFNESS

    def depth(self, held: HeldContact, step: float) -> float:
        """The depth [m] at which a contact rests at `step` [s]."""
        if self.convergent:
            return self.compliance(step) * held.load * held.weight
        return held.depth(self.point or SoftPoint(), step)

    def compliance(self, step: float) -> float:
        """The deflection [m] per normal force [N] and inverse weight [1/kg], at `step` [s]. For
        convergent profiles only."""
        return (1.0 - IMPEDANCE) * (step / STIFFNESS) ** 2


def coulomb_pair(
    step: float, softening: float = SOFTENING, lead: float = 1.0, stiffness: float = STIFFNESS
) -> PairFields:
    """The fields of a contact pair at `step` [s] with which friction converges: it stops a slip
    within the fraction `lead` of a step. The contact's natural frequency times the step is
    `stiffness`."""
    rate = stiffness / step
    return {
        "solimp": np.array([IMPEDANCE, IMPEDANCE, 1e-3, 0.5, 2.0]),
        "solref": np.array([-(rate**2) * softening, -2 * DAMPING * rate * softening]),
        "solreffriction": np.array([-1.0, -(1.0 / lead) * IMPEDANCE / step]),
    }


def stiff_pair(step: float) -> PairFields:
    """The fields of a contact pair at `step` [s] that is as stiff as MuJoCo allows."""
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
"""The stiffest contact that MuJoCo allows: its time constant is two steps, its impedance
largest."""

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
    """The contact profile of a method: the profile that the settings name, or fields of a contact
    that the settings spell out, which no theory covers. Raises ParameterError.

    For motion in the `plane` convergent profiles are softened further, since the coupling of slip
    to a normal force is proportional to the ratio of the slip speed to the step. With RK4 friction
    stops a slip within half a step: RK4's stages apply friction half a step late."""
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
    """The profile of a user's contacts: fields of a contact, and options that change contacts."""
    options = {name: settings[name] for name in OWN_OPTIONS if name in settings}
    tolerances = {name: contact[name] for name in OWN_TOLERANCES if name in contact}
    fields = {name: value for name, value in contact.items() if name not in OWN_TOLERANCES}
    if fields.get("condim") == 3:  # the default: a scene without friction has 1
        del fields["condim"]
    return ContactProfile({**options, **tolerances}, lambda step: fields)


def contacts(problem: CapsuleProblem, settings: Options) -> ContactProfile:
    """The contact profile of a method on a capsule; raises ParameterError."""
    return profile(settings, plane=without_formula(problem))


def scheme(method: Method) -> Scheme:
    """The scheme of `method` on bodies that touch, which includes its soft contacts. No theory
    covers a user's contacts."""
    if not isinstance(method.settings.get("contact", ""), str):
        return Scheme("contacts of a file")
    return replace(method.scheme, contact=profile(method.settings).point)


def drift_error(
    point: SoftPoint, held: HeldContact, duration: float, step: float, inertia: float
) -> ModelError:
    """Bounds on the errors of the displacement `x` and the speed of a body that drifts under
    friction over a `duration` [s], by reason.

    The solver leaves an acceleration in each step, which the contact's damping turns into a speed;
    `inertia` is the inertia of all coordinates over the body's inertia. The settling of normal
    forces changes the drift, too, until the damping has removed that change."""
    damping = rates(point, step)[1]
    solver_speed = math.sqrt(2.0 * inertia * SOLVED) / damping
    settling_speed = 0.0
    if held.holds(point):
        drift = float(np.hypot(*held.drift(point, step)[0]))
        settling_speed = SETTLING * held.settling(point, step) * drift
    return {
        "x": {"solver": solver_speed * duration, "settling": settling_speed / damping},
        "speed": {"solver": solver_speed, "settling": settling_speed},
    }


def soft_contact(problem: CapsuleProblem, settings: Options, step: float) -> SoftContact | None:
    """The record of contacts, or of joint friction, at `step` [s] for theory; None if no theory
    covers them. Raises ParameterError."""
    setup = problem.setup
    mass = setup.capsule.body_mass + setup.capsule.slider_mass
    if settings.get("model", "full") == "reduced":
        if without_formula(problem):
            return None
        drift = (1.0 - JOINT_IMPEDANCE) / JOINT_IMPEDANCE * JOINT_HARDENING * step
        return SoftContact(step, drift / mass, EXACT, armature(setup))
    chosen = contacts(problem, settings)
    if not chosen.convergent:
        return None
    normal = NormalContact(
        compliance=chosen.compliance(step) / mass,
        coupling=chosen.coupling() * mass,
        frequency_step=STIFFNESS,
        damping_ratio=DAMPING,
        tilt_inertia=tilt_inertia(problem),
        height=float(settings.get("height", 0.0)),
    )
    tolerance = float(chosen.options["tolerance"])
    slip = chosen.slip_compliance(step) / mass
    return SoftContact(step, slip, tolerance, armature(setup), normal, integrator_of(settings))


def integrator_of(settings: Options) -> str:
    """The integrator for theory: RK4, or Euler for every other integrator of MuJoCo."""
    return RK4 if settings.get("integrator") == "RK4" else EULER
