"""The capsule in pymunk, for all of its systems: seen from above, on feet or on bare pivots, or
seen from the side."""

from __future__ import annotations

import cmath
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from plumbob.analytic.errors.contact_models import sequential_impulse_bounds
from plumbob.analytic.errors.contact_models.model_error import ObservableErrors
from plumbob.analytic.errors.contact_models.sequential_impulse import (
    SequentialImpulse,
    contacts_factor,
    feet_factor,
    iterations_needed,
    pivots_factor,
    slipping_feet_factor,
)
from plumbob.analytic.systems.capsule import NORMAL_FORCES, Capsule
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.engines.adapters.pymunk.assembly import SETTLING_ITERATIONS, View
from plumbob.engines.adapters.pymunk.capsule_above import foot_mass, from_above
from plumbob.engines.adapters.pymunk.capsule_side import (
    DEPTH,
    along,
    foot_reach,
    from_the_side,
    side_moment,
)
from plumbob.engines.adapters.pymunk.simulation import Translation, settle
from plumbob.engines.adapters.pymunk.slider_drive import driven, targets
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.trajectory import ByName
from plumbob.models.tripod_capsule.observed import largest_magnitudes

# Number of places of a slider that leaves its line, at which the solver's factor is evaluated
PLACES = 65
Read = Callable[[], ByName]


def build(problem: CapsuleProblem, method: Method, step: float) -> Translation:
    """The translation of a capsule, in the model that the method's settings name: seen from above
    on "feet" or on bare "pivots", or seen from the "side". Raises Unsupported."""
    setup = problem.setup
    model = method.settings.get("model")
    turning = bool(setup.heading_rate) or setup.plane_velocity is not None
    if model == "side":
        if turning:
            raise Unsupported("the side view has one line, and here the body turns")
        view = from_the_side(setup)
    elif model in ("feet", "pivots"):
        view = from_above(setup, step, model == "feet", turning)
    else:
        raise Unsupported(f"{method.name} has no model of the capsule")
    parts = view.assembly
    parts.space.iterations = described(problem, method, step).iterations
    act = None
    if setup.tracks:
        places = targets(problem, parts.line, parts.start, step)
        act = driven(view, places, step, setup.plane_velocity is not None)
    settle(parts.space, step, SETTLING_ITERATIONS)
    read, following = _readings(setup, view)
    return Translation(parts.space, read, act, largest_magnitudes(setup), following)


def model_error(
    problem: CapsuleProblem, duration: float, method: Method, step: float
) -> ObservableErrors:
    """Bounds on the error of each observable over `duration` [s], by reason."""
    solver = described(problem, method, step)
    return sequential_impulse_bounds.model_error(problem, duration, solver)


def described(problem: CapsuleProblem, method: Method, step: float) -> SequentialImpulse:
    """The record of the method's model and solver for theory. The number of iterations is the
    method's, or larger if the capsule needs more and more of them help."""
    setup = problem.setup
    capsule = setup.capsule
    model = method.settings["model"]
    iterations = int(method.settings["iterations"])
    reach = foot_reach(setup)
    depth = 0.0
    one_foot = 1.0
    if model == "pivots":
        factor = one_foot = pivots_factor(capsule, np.asarray(setup.slider))
        return SequentialImpulse(model, step, iterations, reach, factor, one_foot)
    if model == "side":
        moment = side_moment(setup)
        depth = DEPTH
        factor = max(
            contacts_factor(capsule, moment, reach, along(setup, (x, y)))
            for x, y in problem.slider_ends
        )
    else:
        mass = foot_mass(capsule)
        factor = _largest_feet_factor(capsule, mass, problem.slider_places(PLACES).tobytes())
        one_foot = slipping_feet_factor(capsule, mass, 1)
    iterations = iterations_needed(factor, iterations)
    return SequentialImpulse(model, step, iterations, reach, factor, one_foot, depth)


@lru_cache(maxsize=32)  # all steps of a scene have the same factor
def _largest_feet_factor(capsule: Capsule, mass: float, places: bytes) -> float:
    """The largest `feet_factor` over places of the slider, given as the bytes of pairs of
    doubles."""
    return max(
        feet_factor(capsule, mass, place) for place in np.frombuffer(places).reshape(-1, 2)
    )


def _readings(setup: CapsuleSetup, view: View) -> tuple[Read, Read | None]:
    """Two functions: one reads the observables at a sample, the other reads the observables of the
    step that begins at the sample, when the step is done. The second is None in the plane.

    The first gives the pose and, along a line, the normal forces N_i. The second gives friction and
    the driving force. pymunk tells the magnitude of a joint's impulse but not its direction:
    friction is therefore the gain of momentum beyond gravity's, and the driving force is the same
    for the slider."""
    if setup.in_plane:
        return view.shown, None
    parts = view.assembly
    slider = parts.slider
    line = cmath.exp(1j * parts.body.angle) * parts.line
    gravity_on_all = sum(part.mass for part in parts.space.bodies) * setup.pull
    momentum_at_sample = 0j
    slider_velocity_at_sample = 0j

    def read() -> ByName:
        """The observables of the pose, and the normal forces."""
        nonlocal momentum_at_sample, slider_velocity_at_sample
        momentum_at_sample = parts.momentum
        slider_velocity_at_sample = complex(*slider.velocity)
        loads = map(float, view.loads())
        return {**view.shown(), **dict(zip(NORMAL_FORCES, loads, strict=True))}

    def following() -> ByName:
        """The friction and the driving force of the step that began at the sample [N]."""
        step = parts.space.current_time_step
        momentum_change = (parts.momentum - momentum_at_sample) / line
        velocity_change = complex(*slider.velocity) - slider_velocity_at_sample
        slider_change = slider.mass * velocity_change / line
        return {
            "friction_force": momentum_change.real / step - gravity_on_all,
            "driving_force": slider_change.real / step - slider.mass * setup.pull,
        }

    return read, following
