"""The capsule in MuJoCo: the full model, with a free joint and three contacts.

The model file is filled with the numbers of a problem: body, supports, contacts, slider. A run
starts where the body rests on its contacts, which deflect."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np

from plumbob.analytic.errors.contact_models import soft_contact_bounds
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import load_fractions
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.capsule import reduced
from plumbob.engines.adapters.mujoco.capsule.readings import (
    acceleration,
    add_sensors,
    control,
    reading,
    scale_tolerance,
    start,
    turned,
)
from plumbob.engines.adapters.mujoco.contacts import (
    ContactProfile,
    contacts,
    soft_contact,
)
from plumbob.engines.adapters.mujoco.translation import (
    Translation,
    at_rest,
    filled,
    set_contacts,
)
from plumbob.engines.method import Method, ModelError, Options, Unsupported
from plumbob.models.tripod_capsule.model import ARMATURE_RATIO, MODEL, armature, impose
from plumbob.models.tripod_capsule.observed import heading_of_attitude

PAIR_FIELDS = ("solimp", "solref", "solreffriction")
OPTIONS_OF_CONTACTS = ("cone", "impratio", "noslip_iterations", "tolerance", "noslip_tolerance")
# There is one body on one plane, and so no islands of contacts to search for.
ISLANDS = mujoco.mjtDisableBit.mjDSBL_ISLAND
# Steps of DEFAULT_STEP until default contacts are at rest: 50 of their time constants
DEFAULT_SETTLING = 1000
# Steps until convergent contacts, whose periods are proportional to the step, are at rest: twenty
# periods; fourteen would suffice
CONVERGENT_SETTLING = 300
DEFAULT_STEP = 1e-3  # [s] step for default contacts, whose time constant is 0.02 s at any step


def build(mjcf: Path, problem: CapsuleProblem, method: Method, step: float) -> Translation:
    """The translation of a capsule, in the full model with a free joint or, if the method's
    settings name it, in the model `reduced` to one line. Raises Unsupported."""
    if method.settings.get("model") == "reduced":
        return reduced.build(mjcf.with_name("reduced.xml"), problem, step)
    setup = problem.setup
    chosen = contacts(problem, method.settings)
    spec = complete_model(mjcf, problem, method.settings, step)
    visual = spec.copy()
    for shown in [geom for geom in spec.geoms if geom.classname.name == "visual"]:
        spec.delete(shown)  # visual geoms have no effect but cost time
    spec.option.disableflags |= ISLANDS

    def tune(compiled: mujoco.MjModel) -> None:
        """Sets the inverse weight of the body, to which the softness of contacts is
        proportional."""
        inverse_mass = compiled.body_invweight0[compiled.body("body").id]
        inverse_mass *= chosen.softening
        if chosen.convergent:
            # MuJoCo computes the inverse mass for a force at C. If the slider is not at C, such a
            # force also turns the body, which makes the inverse mass larger: with m/M = 1e3 the
            # contacts would be 80 times too soft.
            mass = setup.capsule.body_mass + setup.capsule.slider_mass
            inverse_mass[0] = chosen.softening / mass

    if chosen.convergent:
        deflected = statics(setup, spec.body("slider").pos[:2], chosen.compliance(step))
        rest_qpos = settled_qpos(spec, tune, setup.press, step, CONVERGENT_SETTLING, deflected)
    else:
        rest_qpos = settled_qpos(spec, tune, setup.press, DEFAULT_STEP, DEFAULT_SETTLING)
    qpos, qvel = start(setup, rest_qpos)
    add_sensors(spec)
    return Translation(
        spec,
        qpos=qpos,
        qvel=qvel,
        channels=lambda qpos, qvel: {"vertical_displacement": qpos[:, 2] - rest_qpos[2]},
        control=control(setup, step),
        changing_control=acceleration(problem),
        visual=visual,
        sensors=reading(setup),
        tune=tune,
    )


def model_error(
    problem: CapsuleProblem, duration: float, method: Method, step: float
) -> ModelError:
    """Bounds on the error of each observable over `duration` [s], by reason; empty if no theory
    covers the contacts."""
    contact = soft_contact(problem, method.settings, step)
    return soft_contact_bounds.model_error(problem, duration, contact) if contact else {}


def complete_model(
    mjcf: Path, problem: CapsuleProblem, settings: Options, step: float
) -> mujoco.MjSpec:
    """The model of a problem with its visual parts: the file `mjcf` with the problem's numbers, and
    the contacts that the `settings` of a method name at `step` [s]. Other settings change the
    model:

    - `height`: height of C and of the slider above the plane [m]; zero by default, as in the
      source;
    - `slider_ahead`: distance by which the slider starts further along its line than in the problem
      [m]. Beyond an edge the body tips over, where there is no reference;
    - `slider_ratio`: smallest ratio of the slider's armature to its mass.
    """
    setup = problem.setup
    height = float(settings.get("height", 0.0))
    spec = filled(mjcf, MODEL, problem)
    replace_contacts(spec, contacts(problem, settings), step)
    slider_armature = armature(setup, float(settings.get("slider_ratio", ARMATURE_RATIO)))
    impose(spec, slider_armature)
    scale_tolerance(spec, setup, slider_armature)
    spec.body("body").pos = [0.0, 0.0, height]
    for number in (1, 2, 3):
        spec.geom(f"support_{number}").pos[2] -= height
    line = np.array([math.cos(setup.direction), math.sin(setup.direction), 0.0])
    spec.body("slider").pos += float(settings.get("slider_ahead", 0.0)) * line
    return spec


def replace_contacts(spec: mujoco.MjSpec, profile: ContactProfile, step: float) -> None:
    """Sets every contact pair, and the options that belong to contacts, to a profile at `step` [s].
    Fields that the profile does not set get MuJoCo's defaults, whatever the file has."""
    defaults = mujoco.MjSpec()
    pair = defaults.add_pair()
    for name in OPTIONS_OF_CONTACTS:
        setattr(spec.option, name, getattr(defaults.option, name))
    for contact in spec.pairs:
        for name in PAIR_FIELDS:
            setattr(contact, name, getattr(pair, name))
    set_contacts(spec, profile, step)


def settled_qpos(
    spec: mujoco.MjSpec,
    tune: Callable[[mujoco.MjModel], None],
    press: float,
    step: float,
    steps: int,
    deflected: Array | None = None,
) -> Array:
    """The coordinates at rest under a vertical gravity of `press` [m/s^2], shape (nq,), after
    `steps` steps of `step` [s] from the height and slopes `deflected` (see `statics`), or from the
    file's pose if that is None. The horizontal place and the rotation about the vertical are set to
    zero. A run that began elsewhere would begin with a drop. Raises Unsupported if the contacts are
    so soft that the body tips over."""
    resting = spec.copy()
    resting.option.gravity = [0.0, 0.0, -press]
    resting.option.timestep = step
    model = options.compiled(resting)
    tune(model)
    if deflected is not None:
        height, slope_x, slope_y = deflected
        model.qpos0[2] += height
        model.qpos0[4:6] = 0.5 * slope_y, -0.5 * slope_x
        upright = 1.0 - float(np.square(model.qpos0[4:6]).sum())
        if not upright > 0.0:
            raise Unsupported(
                "at this step the body tips over on its contacts: they are too soft"
            )
        model.qpos0[3] = math.sqrt(upright)
    qpos = at_rest(model, steps)
    qpos[:2] = qpos[7:] = 0.0
    qpos[3:7] = turned(qpos[3:7], -float(heading_of_attitude(qpos[3:7])))
    return qpos


def statics(setup: CapsuleSetup, slider: Array, compliance: float) -> Array | None:
    """The height of C above the plane [m] and the slopes of the body's plane along x and y, shape
    (3,), on contacts that deflect under their static loads; None if the slider stands beyond an
    edge, where no body rests. `slider` is the slider's place relative to C [m], `compliance` the
    deflection per force [m/N] times M + m.

    A body that began elsewhere would drop: a support with hardly any load would then take off, and
    land long after the other supports have settled.
    """
    capsule = setup.capsule
    loads = load_fractions(capsule, capsule.mass_ratio * slider)
    if loads.min() <= 0.0:
        return None
    places = np.column_stack([np.ones(3), np.asarray(capsule.supports)])
    return np.linalg.solve(places, -compliance * setup.press * loads)
