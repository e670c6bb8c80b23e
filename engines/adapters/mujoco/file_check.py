"""Compares a user's model file with a method's settings for the file's time step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import copy
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.errors.contact_models.contact_stability import (
    ContactSpring,
    largest_contact_step,
)
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import Scheme
from plumbob.engines.abilities import FileCheck
from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.contacts import (
    IMPEDANCE,
    PLANE_SOFTENING,
    REGULARISATION_RATIO,
    SOFTENING,
    profile,
)
from plumbob.engines.adapters.mujoco.options import numbers_text
from plumbob.engines.adapters.mujoco.settings_to_paste import OWN_STIFFNESS, own_pair
from plumbob.engines.adapters.mujoco.user_file import SOLVER_TOLERANCES, compiled_model
from plumbob.engines.method import Method, time_step
from plumbob.engines.own_motion import NotCertifiable

CLOSE = 1e-6  # largest relative difference of equal values, whose digits are rounded in a file
# Distance at which a geom counts as touching at the start, as a fraction of a body's mean size
REACH = 1e-2
ONE_STEP = 1.01  # smallest ratio of two steps that differ
FREE_BODY = 1.0  # squared frequency ratio if nothing touches


def check(path: Path, method: Method) -> FileCheck:
    """The differences of a file's options and contacts from those of a method, and warnings about
    contacts that do not suit the file's time step; raises ParameterError."""
    model = compiled_model(path, "check")
    step = time_step("check", model.opt.timestep, str(path))
    chosen = profile(method.settings)
    convergent = chosen.convergent and method.settings.get("model", "full") == "full"
    differences = [*_options(model, method, dict(chosen.options))]
    if convergent:
        differences += _contacts(model, method, step)
    try:
        warnings = tuple(_warnings(model, method, step))
    except NotCertifiable as why:
        raise ParameterError("check", str(path), f"a model that starts; {why}") from None
    return FileCheck(method.name, step, tuple(dict.fromkeys(differences)), warnings)


def _options(
    model: mujoco.MjModel, method: Method, wanted: dict[str, Any]
) -> Iterator[tuple[str, str, str]]:
    """Yields each option of a model that differs from the method's: name, value, wanted value."""
    spec = mujoco.MjSpec()
    options.apply(spec, {"integrator": method.settings["integrator"], **wanted}, 1.0)
    for name in ("integrator", *wanted):
        value = float(getattr(model.opt, name))
        wanted_value = float(getattr(spec.option, name))
        if name == "impratio" and "coulomb" in str(method.settings.get("contact")):
            wanted_value = REGULARISATION_RATIO * _softening(model)
        # A tolerance may be tighter than wanted.
        tighter = name in SOLVER_TOLERANCES and value <= wanted_value
        if not (tighter or _close(value, wanted_value)):
            word = options.word(name, wanted_value)
            yield f"option/{name}", options.word(name, value), word


def _contacts(
    model: mujoco.MjModel, method: Method, step: float
) -> Iterator[tuple[str, str, str]]:
    """Yields each field of contact pairs that differs from the method's: name, value, wanted value.
    Any stable stiffness counts as right."""
    if not model.npair:
        yield "contact", "no <pair>", "<pair>: a <geom> has no solreffriction"
    softening = _softening(model)
    for pair in range(model.npair):
        stiffness = math.sqrt(max(-model.pair_solref[pair, 0] / softening, 0.0)) * step
        friction_rate = model.pair_solreffriction[pair, 1]
        right_friction = any(_close(friction_rate, rate) for rate in _rates(method, step))
        wanted = own_pair(method, step, softening, stiffness or OWN_STIFFNESS)
        for name, wanted_numbers in wanted.items():
            value = getattr(model, f"pair_{name}")[pair][:3]
            equal = all(map(_close, value, wanted_numbers[:3]))
            if not (equal or (right_friction and name == "solreffriction")):
                yield f"pair/{name}", numbers_text(value), numbers_text(wanted_numbers[:3])
        if model.pair_dim[pair] != 3:
            yield "pair/condim", str(model.pair_dim[pair]), "3"


def _warnings(model: mujoco.MjModel, method: Method, step: float) -> Iterator[str]:
    """Warns of contacts that are written for another step, and of contacts that are unstable at
    this step."""
    steps = _steps_of_another(model, method, step)
    if steps:
        words = " or ".join(dict.fromkeys(f"{other:g}" for other in steps))
        yield (
            f"contacts are written for a time step of {words} s, and the file's is "
            f"{step:g} s (`plumbob settings {method.name} --step {step:g}`)"
        )
    limit = _largest_stable_step(model, method)
    if step > limit:
        yield (
            f"contacts are too stiff for a time step of {step:g} s: the body may be thrown up "
            f"(while it slides, they are stable up to {limit:.3g} s; a smaller --stiffness allows "
            "more)"
        )


def _steps_of_another(model: mujoco.MjModel, method: Method, step: float) -> list[float]:
    """The steps [s] for which the first pair may be written that is written for another step than
    `step`, as the rate of its friction shows; empty if there is no such pair."""
    impedances = model.pair_solimp[:, 1]
    for (kind, rate), impedance in zip(model.pair_solreffriction, impedances, strict=True):
        convergent = max(kind, rate) < 0.0 and _close(impedance, IMPEDANCE)
        if convergent:
            steps = [step * right_rate / rate for right_rate in _rates(method, step)]
            if not any(1.0 / ONE_STEP < other / step < ONE_STEP for other in steps):
                return steps
    return []


def _largest_stable_step(model: mujoco.MjModel, method: Method) -> float:
    """The largest step [s] at which all contacts with a direct `solref` are stable, as the fastest
    mode of the body on them shows; infinite if there are none."""
    solref = np.vstack([model.pair_solref, model.geom_solref]).tolist()
    impedances = np.append(model.pair_solimp[:, 1], model.geom_solimp[:, 1]).tolist()
    softening = _softening(model)
    springs = {
        ContactSpring(
            -stiffness / impedance,
            -damping / impedance,
            softening * (1.0 - impedance) / impedance,
        )
        for (stiffness, damping), impedance in zip(solref, impedances, strict=True)
        if stiffness < 0.0 and damping <= 0.0
    }
    scheme = Scheme(method.scheme.integrator)  # the damping of contacts is explicit
    ratio = frequency_ratio(model)
    limits = [largest_contact_step(ratio, spring, scheme) for spring in springs]
    return min(limits, default=math.inf)


def _rates(method: Method, step: float) -> tuple[float, ...]:
    """The right values of the second number of `solreffriction`. There are two: with RK4 friction
    of motion on a line may also stop a slip within a whole step."""
    return float(own_pair(method, step)["solreffriction"][1]), -IMPEDANCE / step


def frequency_ratio(model: mujoco.MjModel) -> float:
    """The squared frequency of the fastest oscillation on the contacts at the model's start, over
    the squared frequency of one contact alone. With the contacts' normal Jacobian J it is the
    largest eigenvalue of J M^-1 J', scaled by the contacts' inverse weights."""
    model, data = _touching_start(model)
    geoms = data.contact.geom  # -1 where a flex touches
    weights = model.body_invweight0[model.geom_bodyid[geoms], 0].sum(axis=1)
    # A body whose centre of mass is on its axis has no inverse weight: no spring holds it.
    sprung = (data.contact.efc_address >= 0) & (geoms >= 0).all(axis=1) & (weights > 0.0)
    if not sprung.any():
        return FREE_BODY
    normal_rows = data.contact.efc_address[sprung]
    jacobian = data.efc_J.reshape(data.nefc, model.nv)[normal_rows]
    accelerations = np.zeros_like(jacobian)  # J M^-1: accelerations under unit normal forces
    mujoco.mj_solveM(model, data, accelerations, jacobian)
    scales = np.sqrt(np.outer(weights[sprung], weights[sprung]))
    return float(np.linalg.eigvalsh((jacobian @ accelerations.T) / scales).max())


def _touching_start(model: mujoco.MjModel) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A copy of a model whose geoms also touch if they are REACH apart, and its data at the start,
    with all constraints computed."""
    copied = copy(model)
    reach = REACH * float(model.stat.meansize)
    copied.pair_margin[:] += reach
    copied.geom_margin[:] += reach
    copied.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    copied.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data = mujoco.MjData(copied)
    if copied.nkey:
        mujoco.mj_resetDataKeyframe(copied, data, 0)
    with options.collected():
        mujoco.mj_forward(copied, data)
    return copied, data


def _softening(model: mujoco.MjModel) -> float:
    """The factor on inverse weights to which the file's `impratio` belongs; 1 if there is none."""
    ratio = model.opt.impratio / REGULARISATION_RATIO
    for softening in (SOFTENING, PLANE_SOFTENING):
        if _close(ratio, softening):
            return softening
    return 1.0


def _close(value: float, other: float) -> bool:
    """Whether two numbers of a file are equal, up to rounded digits."""
    return math.isclose(value, other, rel_tol=CLOSE, abs_tol=1e-300)
