"""Settings to paste into a user's model: a method's options and contacts as MJCF and Python.

Contacts of plumbob's scenes (STIFFNESS in contacts.py) are as stiff as a body on three supports
allows. Contacts for a user's model are softer: they are stable up to an oscillation at 14.3^(1/2)
times one contact's frequency. A solid body on four feet under its corners tilts at 12^(1/2) times
it."""

from __future__ import annotations

import re
from types import MappingProxyType
from xml.sax.saxutils import quoteattr

from plumbob.analytic.errors.contact_models.contact_stability import largest_ratio
from plumbob.analytic.errors.contact_models.soft_friction import impedance, rates
from plumbob.analytic.errors.sliding_motion.plane_steps import FRICTION_LEADS
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import Scheme, SoftPoint
from plumbob.engines.abilities import Settings, Snippet
from plumbob.engines.adapters.mujoco.contacts import (
    DAMPING,
    IMPEDANCE,
    PLANE_SOFTENING,
    REGULARISATION_RATIO,
    ContactProfile,
    PairFields,
    coulomb_pair,
    integrator_of,
    profile,
)
from plumbob.engines.method import Method

OWN_STIFFNESS = 0.2  # natural frequency of one contact times the step, in a user's model
# Smallest stiffness: the static penetration is proportional to its inverse square
SOFTEST = 1e-6
SLIDING = (
    "for bodies that slide and stop under dry friction, at this fixed step; tried on a four-footed "
    "box, a four-legged stand and a wheeled base with locked wheels"
)
# powers of the step to which the numbers of these fields are proportional
POWERS = MappingProxyType({"solref": (-2, -1), "solreffriction": (0, -1)})
PAIRS = (
    '<contact>\n  <!-- one line for each geom that touches the floor -->\n  <pair geom1="floor" '
    'geom2="foot_1"/>\n</contact>'
)
MIDPOINT = (
    "data.ctrl[:] = control(data.time + model.opt.timestep / 2)  # before each step\n"
    "mujoco.mj_step(model, data)"
)
NO_PREDICTION = "none is predicted"


def settings(method: Method, step: float, stiffness: float | None, friction: float) -> Settings:
    """The settings to paste for `method` at `step` [s]; raises ParameterError."""
    chosen = profile(method.settings)
    if method.settings.get("model") == "reduced":
        raise ParameterError("method", method.name, "one whose model is the full body")
    if stiffness is not None and not chosen.convergent:
        raise ParameterError(
            "stiffness", stiffness, "left out: it is for `+coulomb` methods only"
        )
    if stiffness is not None and not SOFTEST <= stiffness <= 1.0:
        allowed = f"from {SOFTEST:g} to 1: no contact is stable at more"
        raise ParameterError("stiffness", stiffness, allowed)
    if chosen.convergent:
        return _convergent(method, chosen, step, stiffness or OWN_STIFFNESS, friction)
    if "contact" in method.settings:
        return _other_contacts(method, chosen, step, friction)
    return _integrator(method, step)


def own_pair(
    method: Method, step: float, softening: float = 1.0, stiffness: float = OWN_STIFFNESS
) -> PairFields:
    """The fields of a contact pair with which friction converges in a user's model, with `method`
    at `step` [s], if the inverse weights of the bodies are overstated by `softening`."""
    lead = FRICTION_LEADS[integrator_of(method.settings)]
    return coulomb_pair(step, softening, lead, stiffness)


def _convergent(
    method: Method, chosen: ContactProfile, step: float, stiffness: float, friction: float
) -> Settings:
    """The settings of a method with convergent contacts."""
    rk4 = method.settings["integrator"] == "RK4"
    first = 0.0 if rk4 else -step / 2
    leading = "no term of first order" if rk4 else f"{first:.6g} s times the initial speed"
    tilt = (step / stiffness) ** 2
    error = (
        f"stopping distance: {leading}; and {-tilt:.3g} s^2 times f g h^2/sum(b_i^2), as a body "
        "tilts on its contacts (centre of mass at a height h, feet at b_i from it along the "
        "motion); slip at a speed v changes normal forces, until the body has settled on them, by"
    )
    cost_ratio = "1.6" if "noslip_iterations" in chosen.options else "1.2"
    if rk4:
        cost_ratio = "4.5"
    cost = f"{cost_ratio} times a step of Euler with default contacts"
    scheme = Scheme(method.scheme.integrator)  # the damping of contacts is explicit
    ratio = largest_ratio(stiffness, DAMPING, scheme)
    stable = (
        f"stable if the sliding body bounces on its contacts at less than {ratio**0.5:.2g} times "
        "the frequency of one contact; `plumbob settings --check` checks that, and a smaller "
        "--stiffness allows more"
    )

    def mjcf(softening: float) -> str:
        """The lines for bodies whose inverse weights are overstated by `softening`."""
        options = {**chosen.options, "impratio": REGULARISATION_RATIO * softening}
        fields = own_pair(method, step, softening, stiffness)
        pair = default_element("pair", fields, condim=3, friction=(friction, friction))
        parts = [_option(method, step, options), pair, PAIRS]
        return "\n".join(
            (f"<!-- contacts for a time step of {step:g} s, and no other -->", *parts)
        )

    alone = Snippet(
        "MJCF alone, for bodies that slide without turning",
        mjcf(1.0),
        "",
        f"{error} {IMPEDANCE:g} f m v/dt",
        cost,
        f"{SLIDING}; {stable}",
    )
    softened = Snippet(
        "MJCF and a line of Python after compiling, for bodies that also turn",
        mjcf(PLANE_SOFTENING),
        f'model.body_invweight0[model.body("base").id] *= {PLANE_SOFTENING:g}'
        "  # each body that touches the floor",
        f"{error} {IMPEDANCE / PLANE_SOFTENING:g} f m v/dt, which suits bodies that turn too",
        cost,
        f"{SLIDING}; {stable}; joint limits and equality constraints of these bodies are softened "
        "too",
    )
    return Settings(method.name, step, first, (alone, softened))


def _other_contacts(
    method: Method, chosen: ContactProfile, step: float, friction: float
) -> Settings:
    """The settings of a method with contacts that do not converge."""
    fields = chosen.pair(step)
    geom = default_element("geom", fields, friction=friction)
    text = "\n".join((_option(method, step, dict(chosen.options)), geom))
    error = f"{NO_PREDICTION}: a sliding body chatters, and a smaller step does not help"
    holds = "nowhere to a given accuracy; mujoco/euler+coulomb converges"
    point = chosen.point or SoftPoint()
    soft = 1.0 / impedance(point, 0.0) - 1.0
    if "solref" in fields:
        depth = soft / point.impedance[1] / rates(point, step)[0]
        error = (
            f"what stands is {depth:.3g} s^2 times the normal force of a contact times the sum of "
            "both bodies' `body_invweight0` deep in what it stands on. Of what slides " + error
        )
        holds = (
            f"for stacks; tried on free cubes of 1e-4 to 1e4 times the mass; sliding {holds}"
        )
    elif not point.pyramidal:
        drift = soft / rates(point, step)[1] / float(chosen.options["impratio"])
        error = (
            f"what friction holds drifts by at most {drift:.3g} s times the friction force of one "
            "contact times the sum of both bodies' `body_invweight0`, with the default solref and "
            "solimp; it goes as 1/impratio. Of what slides " + error
        )
        holds = (
            "for what is held, as in a gripper; tried on two box fingers and on robosuite's Panda "
            f"gripper with a cube, to an impratio of 1e4; of what slides {holds}"
        )
    cost = "0.9 to 1.5 times a step with default contacts"
    return Settings(
        method.name, step, None, (Snippet("MJCF alone", text, "", error, cost, holds),)
    )


def _integrator(method: Method, step: float) -> Settings:
    """The settings of a method without contact settings."""
    cost = f"{4 if method.settings['integrator'] == 'RK4' else 1} times a step of Euler"
    if method.order == 1:
        error = "of first order in the step"
    elif method.scheme.control == "midpoint":
        error = (
            "of second order in the step where a control is read at mid-step, of fourth without"
        )
    else:
        error = "of fourth order in the step; of first where a control is held over a step"
    python = MIDPOINT if method.scheme.control == "midpoint" else ""
    snippet = Snippet(
        "MJCF, and how to step" if python else "MJCF alone",
        _option(method, step, {}),
        python,
        error,
        cost,
        "for smooth motion on joints; sliding contacts need the `+coulomb` methods",
    )
    return Settings(method.name, step, None, (snippet,))


def _option(method: Method, step: float, options: dict[str, object]) -> str:
    """The <option> element of a method at a step [s]."""
    attributes = {"timestep": step, "integrator": method.settings["integrator"], **options}
    return f"<option {attributes_text(attributes)}/>"


def default_element(part: str, pair: PairFields, **more: object) -> str:
    """The <default> element with fields of a contact, and `more` fields, of a `part` such as
    "geom". The numbers of `solimp` that are MuJoCo's defaults are left out."""
    fields = {**more, **{name: tuple(value[:3]) for name, value in pair.items()}}
    return f"<default>\n  <{part} {attributes_text(fields)}/>\n</default>"


def attributes_text(attributes: dict[str, object]) -> str:
    """Attributes of an MJCF element as text."""

    def text(value: object) -> str:
        """The text of a value."""
        if isinstance(value, tuple):
            return " ".join(map(text, value))
        return _short(value) if isinstance(value, (int, float)) else str(value)

    def quoted(value: object) -> str:
        """The text of a value in quotes, in which a name may have any character."""
        return quoteattr(text(value), {'"': "&quot;"})

    return " ".join(f"{name}={quoted(value)}" for name, value in attributes.items())


def _short(value: float) -> str:
    """A number with up to twelve digits, with or without an exponent, whichever is shorter."""
    mantissa, _, exponent = f"{value:.11e}".partition("e")
    plain = f"{value:.12g}"
    scaled = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return min(plain, scaled, key=len)


def rewritten(text: str, step: float) -> str:
    """The text of one of plumbob's model files with contacts for `step` [s], as a comment in its
    first line says. The numbers of a direct `solref` go as 1/dt^2 and 1/dt, a rest position on
    contacts as dt^2."""
    timestep = re.search(r'timestep="([^"]+)"', text)
    if timestep is None:
        return text
    ratio = step / float(timestep[1])

    def scaled(match: re.Match[str]) -> str:
        """A field with its numbers for the new step."""
        powers = POWERS[match[1]]
        numbers = [float(number) for number in match[2].split()]
        scaled_numbers = [n * ratio**power for n, power in zip(numbers, powers, strict=True)]
        return f'{match[1]}="{" ".join(map(_short, scaled_numbers))}"'

    text = re.sub(r'\b(solref|solreffriction)="([^"]+)"', scaled, text)
    text = re.sub(
        r'(qpos="0 0 )(\S+)', lambda match: match[1] + _short(float(match[2]) * ratio**2), text
    )
    text = text.replace(timestep[0], f'timestep="{_short(step)}"')
    text = re.sub(r"time step 1e-4\b", f"time step {_short(step)}", text)
    return f"<!-- Contacts for a time step of {_short(step)} s, and no other. -->\n{text}"
