"""The capsule in pymunk, for all its systems: seen from above on feet or on bare pivots, or from
the side."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from plumbob.analytic.errors.contact_models import sequential_impulse_bounds
from plumbob.analytic.errors.contact_models.model_error import ModelError
from plumbob.analytic.errors.contact_models.sequential_impulse import (
    SequentialImpulse,
    contacts_factor,
    feet_factor,
    iterations_needed,
    pivots_factor,
    slipping_feet_factor,
)
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Capsule
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.engines.adapters.pymunk import capsule_above, capsule_side, slider_drive
from plumbob.engines.adapters.pymunk.assembly import SETTLING_ITERATIONS, Assembly
from plumbob.engines.adapters.pymunk.capsule_above import (
    foot_mass,
    friction_limits,
    on_feet,
    on_pivots,
)
from plumbob.engines.adapters.pymunk.capsule_side import along, foot_reach, side_moment, standing
from plumbob.engines.adapters.pymunk.simulation import Translation, settle
from plumbob.engines.adapters.three_feet import limits
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.trajectory import ByName

PLACES = 65  # of a slider that does not keep to one line, to find its largest factor
Read = Callable[[], ByName]
Readings = tuple[Read, Read | None]  # at a sample, and once the step that begins there is done


def build(problem: CapsuleProblem, method: Method, step: float) -> Translation:
    """Translate a capsule's problem in the model that the method's settings name: seen from above
    on `feet` or on bare `pivots`, or seen from the `side`; raises Unsupported."""
    model = method.settings.get("model")
    if model == "side":
        return _beside(problem, method, step)
    if model in ("feet", "pivots"):
        return _above(problem, method, step)
    raise Unsupported(f"{method.name} has no model of the capsule")


def model_error(
    problem: CapsuleProblem, duration: float, method: Method, step: float
) -> ModelError:
    """Bounds on the model's error of each observable over `duration` [s], by reason."""
    solver = described(problem, method, step)
    return sequential_impulse_bounds.model_error(problem, duration, solver)


def described(problem: CapsuleProblem, method: Method, step: float) -> SequentialImpulse:
    """The method's model and solver as theory needs them: the iterations are the method's, or as
    many more as the capsule needs where more of them help."""
    capsule, reach = problem.setup.capsule, foot_reach(problem.setup)
    model, least = method.settings["model"], int(method.settings["iterations"])
    if model == "pivots":
        slowest = pivots_factor(capsule, np.asarray(problem.setup.slider))
        return SequentialImpulse(model, step, least, reach, slowest, slowest)
    if model == "side":
        moment = side_moment(problem.setup)
        ends = [along(problem.setup, (x, y)) for x, y in problem.slider_ends]
        factor = max(contacts_factor(capsule, moment, reach, end) for end in ends)
        iterations = iterations_needed(factor, least)
        return SequentialImpulse(model, step, iterations, reach, factor, depth=capsule_side.DEPTH)
    mass = foot_mass(capsule)
    factor = _largest_feet_factor(capsule, mass, _slider_places(problem).tobytes())
    one_foot = slipping_feet_factor(capsule, mass, 1)
    return SequentialImpulse(model, step, iterations_needed(factor, least), reach, factor, one_foot)


@lru_cache(maxsize=32)  # the same for every step of a scene
def _largest_feet_factor(capsule: Capsule, mass: float, places: bytes) -> float:
    """The largest `feet_factor` over `places` of the slider, pairs of doubles."""
    return max(feet_factor(capsule, mass, place) for place in np.frombuffer(places).reshape(-1, 2))


def _slider_places(problem: CapsuleProblem) -> Array:
    """Places of the slider on its way from C [m], shape (n, 2)."""
    if (place := problem.setup.plane_place) is not None:
        return place(np.linspace(0.0, problem.motion.duration, PLACES))
    if problem.setup.in_plane:
        return np.array([problem.setup.slider])
    return problem.slider_ends


def _turns(setup: CapsuleSetup) -> bool:
    """Whether the body turns."""
    return bool(setup.heading_rate) or setup.plane_velocity is not None


def _above(problem: CapsuleProblem, method: Method, step: float) -> Translation:
    setup = problem.setup
    if method.settings["model"] == "feet":
        assembly = on_feet(setup, step, turning=_turns(setup))
    else:
        assembly = on_pivots(setup, step)
    assembly.space.iterations = described(problem, method, step).iterations
    set_limits, act = friction_limits(setup, assembly.friction_joints), None
    if (velocity := slider_drive.on_the_line(setup)) is not None:
        targets = slider_drive.velocity_targets(velocity, setup.slider, step)
        act = slider_drive.driven_along(assembly, targets, setup.heading, set_limits)
    elif problem.motion.kind == "plane" and setup.plane_velocity is not None:
        targets = slider_drive.plane_targets(problem.motion.path, setup, step)
        act = slider_drive.driven(assembly, targets, step, set_limits)
    settle(assembly.space, step, SETTLING_ITERATIONS)
    readings = capsule_above.readings(setup, assembly)
    return _translated(setup, assembly, act, readings)


def _beside(problem: CapsuleProblem, method: Method, step: float) -> Translation:
    setup = problem.setup
    if _turns(setup):
        raise Unsupported("the side view has one line, and here the body turns")
    stand, act = standing(setup), None
    stand.assembly.space.iterations = described(problem, method, step).iterations
    if (velocity := setup.relative_velocity) is not None:
        targets = slider_drive.velocity_targets(
            slider_drive.on_an_axis(velocity), (along(setup, setup.slider), 0.0), step
        )
        act = slider_drive.driven_along(stand.assembly, targets, 0.0, slider_drive.no_limits)
    settle(stand.assembly.space, step, SETTLING_ITERATIONS)
    readings = capsule_side.readings(setup, stand)
    return _translated(setup, stand.assembly, act, readings)


def _translated(
    setup: CapsuleSetup, assembly: Assembly, act: slider_drive.Act | None, readings: Readings
) -> Translation:
    read, following = readings
    return Translation(assembly.space, read, act, limits(setup), following)
