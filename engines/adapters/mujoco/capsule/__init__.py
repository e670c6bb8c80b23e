"""The capsule in MuJoCo's terms: the full model, with a free joint and three contacts.

The model's file with a problem's numbers in it (body, supports, contacts, slider), and the start of
a run, which is where the body rests on contacts that deflect.
"""

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
    with_contacts,
)
from plumbob.engines.method import Method, ModelError, Options, Unsupported
from plumbob.models.tripod_capsule.model import ARMATURE_RATIO, MODEL, armature, impose
from plumbob.models.tripod_capsule.observed import heading

PAIR = ("solimp", "solref", "solreffriction")
OPTIONS = ("cone", "impratio", "noslip_iterations", "tolerance", "noslip_tolerance")
# One body on one plane: there are no islands of contacts to search for.
ISLANDS = mujoco.mjtDisableBit.mjDSBL_ISLAND
SETTLING = 1000  # steps of DEFAULT_STEP: 50 time constants of default contacts
SETTLED = 300  # steps: twenty periods of contacts that converge, at rest after 200
DEFAULT_STEP = 1e-3  # [s], for contacts with a time constant of their own, 0.02 s by default


def build(mjcf: Path, problem: CapsuleProblem, method: Method, step: float) -> Translation:
    """Translate a capsule's problem, in the model that the method's settings name: the full one
    with a free joint, or `reduced` to one line; raises Unsupported."""
    if method.settings.get("model") == "reduced":
        return reduced.build(mjcf.with_name("reduced.xml"), problem, step)
    setup = problem.setup
    chosen = contacts(problem, method.settings)
    spec = whole(mjcf, problem, method.settings, step)
    visual = spec.copy()
    for shown in [geom for geom in spec.geoms if geom.classname.name == "visual"]:
        spec.delete(shown)  # without effect, and a step costs less without them
    spec.option.disableflags |= ISLANDS

    def tune(compiled: mujoco.MjModel) -> None:
        inverse_mass = compiled.body_invweight0[compiled.body("body").id]
        inverse_mass *= chosen.softening
        if chosen.convergent:
            # MuJoCo's own inverse mass is that of a force at C. Where the slider is elsewhere, that
            # force also turns the body, which makes the inverse mass larger: with m/M = 1e3 the
            # contacts would be 80 times softer than they are meant to be.
            mass = setup.capsule.body_mass + setup.capsule.slider_mass
            inverse_mass[0] = chosen.softening / mass

    if chosen.convergent:
        deflected = statics(setup, spec.body("slider").pos[:2], chosen.compliance(step))
        rest_qpos = settled(spec, tune, setup.press, step, SETTLED, deflected)
    else:
        rest_qpos = settled(spec, tune, setup.press, DEFAULT_STEP, SETTLING)
    qpos, qvel = start(setup, rest_qpos)
    add_sensors(spec)
    return Translation(
        spec,
        qpos=qpos,
        qvel=qvel,
        channels=lambda qpos, qvel: {"vertical_displacement": qpos[:, 2] - rest_qpos[2]},
        control=control(setup, step),
        changing_control=acceleration(problem),
        whole=visual,
        sensors=reading(setup),
        tune=tune,
    )


def model_error(
    problem: CapsuleProblem, duration: float, method: Method, step: float
) -> ModelError:
    """Bounds on the model's error of each observable over `duration` [s], by reason, where theory
    covers its contacts."""
    contact = soft_contact(problem, method.settings, step)
    return soft_contact_bounds.model_error(problem, duration, contact) if contact else {}


def whole(
    mjcf: Path,
    problem: CapsuleProblem,
    settings: Options | None = None,
    step: float = 1e-4,
) -> mujoco.MjSpec:
    """The model in the file `mjcf`, or in the one beside it where the slider leaves its line, with
    the numbers of `problem`, visual parts included, and the contacts that `settings` name at `step`
    [s]: by default those that converge.

    The height of C and of the slider above the plane is `settings["height"]` [m]; zero, as in the
    source, unless given. The slider starts `settings["slider_ahead"]` [m] further along its line
    than in the problem, which may be where no reference goes: beyond an edge the body tips over.
    Its armature is `settings["slider_ratio"]` times its mass or more, if that is given.
    """
    chosen = {"contact": "coulomb"} if settings is None else settings
    setup = problem.setup
    height = float(chosen.get("height", 0.0))
    spec = filled(mjcf, MODEL, problem)
    set_contacts(spec, contacts(problem, chosen), step)
    hold = armature(setup, float(chosen.get("slider_ratio", ARMATURE_RATIO)))
    impose(spec, hold)
    scale_tolerance(spec, setup, hold)
    spec.body("body").pos = [0.0, 0.0, height]
    for number in (1, 2, 3):
        spec.geom(f"support_{number}").pos[2] -= height
    line = np.array([math.cos(setup.direction), math.sin(setup.direction), 0.0])
    spec.body("slider").pos += float(chosen.get("slider_ahead", 0.0)) * line
    return spec


def set_contacts(spec: mujoco.MjSpec, chosen: ContactProfile, step: float) -> None:
    """Set every contact pair, and the options that go with it, to a profile at `step` [s]; what
    the profile leaves open takes MuJoCo's default, whatever the file says."""
    defaults = mujoco.MjSpec()
    pair = defaults.add_pair()
    for name in OPTIONS:
        setattr(spec.option, name, getattr(defaults.option, name))
    for contact in spec.pairs:
        for name in PAIR:
            setattr(contact, name, getattr(pair, name))
    with_contacts(spec, chosen, step)


def settled(
    spec: mujoco.MjSpec,
    tune: Callable[[mujoco.MjModel], None],
    press: float,
    step: float,
    steps: int,
    deflected: Array | None = None,
) -> Array:
    """Coordinates at rest under gravity of `press` [m/s^2] alone, shape (nq,), after so many
    `steps` of `step` [s], with the first two and any turn about the vertical at zero: a run from
    elsewhere begins with a drop. The body begins `deflected` (`statics`)."""
    resting = spec.copy()
    resting.option.gravity = [0.0, 0.0, -press]
    resting.option.timestep = step
    model = options.compiled(resting)
    tune(model)
    if deflected is not None:
        model.qpos0[2] += deflected[0]
        model.qpos0[4:6] = 0.5 * deflected[2], -0.5 * deflected[1]
        if not (upright := 1.0 - float(np.square(model.qpos0[4:6]).sum())) > 0.0:
            raise Unsupported(
                "at this step the body tips over on its contacts: they are too soft"
            )
        model.qpos0[3] = math.sqrt(upright)
    qpos = at_rest(model, steps)
    qpos[:2] = qpos[7:] = 0.0
    qpos[3:7] = turned(qpos[3:7], -float(heading(qpos[3:7])))
    return qpos


def statics(setup: CapsuleSetup, slider: Array, compliance: float) -> Array | None:
    """Height of C over the plane [m] and gradient of the body's plane along its x and y, shape
    (3,), on contacts that deflect by `compliance` [m/N] times M + m under the loads of statics with
    the `slider` there [m, from C]; None where it stands beyond an edge, and nothing rests.

    A body that begins elsewhere drops: a support with hardly any load then takes off, and lands
    when the rest has long settled.
    """
    capsule = setup.capsule
    loads = load_fractions(capsule, capsule.mass_ratio * slider)
    if loads.min() <= 0.0:
        return None
    places = np.column_stack([np.ones(3), np.asarray(capsule.supports)])
    return np.linalg.solve(places, -compliance * setup.press * loads)
