"""The capsule in pymunk's terms: what the builders of its systems share."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule_setup import CapsuleProblem, CapsuleSetup
from plumbob.analytic.systems.three_points.reference import PlaneReference
from plumbob.engines.adapters.pymunk import (
    capsule_drive,
    capsule_pressure,
    capsule_reading,
    capsule_shares,
)
from plumbob.engines.adapters.pymunk.capsule_feet import feet, feet_left_by_sweep
from plumbob.engines.adapters.pymunk.capsule_pivots import pivots
from plumbob.engines.adapters.pymunk.capsule_plane_shares import plane_shares
from plumbob.engines.adapters.pymunk.capsule_side import along, side_left_by_sweep, standing
from plumbob.engines.adapters.pymunk.capsule_space import Assembly, settle, told
from plumbob.engines.adapters.pymunk.capsule_sweeps import sweeps
from plumbob.engines.adapters.pymunk.translation import Translation
from plumbob.engines.method import Method, Unsupported

FAR = 1e3  # [m]: no body that only slides gets there
LOOKED_AT = 65  # places of a slider that does not keep to one line
Read = capsule_reading.Read
Seen = tuple[Read, Read | None]  # at a sample, and once the step that begins there is done
LIMITS = MappingProxyType(dict.fromkeys(("displacement", "x", "y"), FAR))


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
) -> Mapping[str, Mapping[str, float]]:
    """What the model adds to each observable, by reason; of bare pivots theory knows little."""
    model, left = method.settings["model"], 0.0
    if model == "pivots":
        if isinstance(problem.reference, PlaneReference):
            return {}
        return capsule_shares.shares(problem, duration, model, left, step)
    slowest, count = left_by_sweep(problem, method), iterations(problem, method)
    if isinstance(problem.reference, PlaneReference):
        return plane_shares(problem, duration, slowest, count, step)
    left = capsule_shares.left_by_sweeps(problem, model, slowest, count)
    return capsule_shares.shares(problem, duration, model, left, step)


def left_by_sweep(problem: CapsuleProblem, method: Method) -> float:
    """Largest share of a velocity that a sweep of the solver leaves while friction holds."""
    setup = problem.setup
    if method.settings["model"] == "side":
        ends = [along(setup, (x, y)) for x, y in problem.slider_ends]
        return max(side_left_by_sweep(setup, end) for end in ends)
    return max(feet_left_by_sweep(setup.capsule, place) for place in slider_places(problem))


def iterations(problem: CapsuleProblem, method: Method) -> int:
    """Sweeps of the solver in a step: the method's, or as many more as the capsule needs where
    more of them help."""
    least = int(method.settings["iterations"])
    if method.settings["model"] == "pivots":
        return least
    return sweeps(left_by_sweep(problem, method), least)


def slider_places(problem: CapsuleProblem) -> Array:
    """Places of the slider on its way from C [m], shape (n, 2)."""
    if (place := problem.setup.plane_place) is not None:
        return place(np.linspace(0.0, problem.motion.duration, LOOKED_AT))
    if problem.setup.in_plane:
        return np.array([problem.setup.slider])
    return problem.slider_ends


def turns(setup: CapsuleSetup) -> bool:
    """Whether the body turns."""
    return bool(setup.heading_rate) or setup.plane_velocity is not None


def _above(problem: CapsuleProblem, method: Method, step: float) -> Translation:
    setup = problem.setup
    if method.settings["model"] == "feet":
        assembly = feet(setup, step, turning=turns(setup))
    else:
        assembly = pivots(setup, step)
    assembly.space.iterations = iterations(problem, method)
    tell, act = told(setup, assembly.grips), None
    if (velocity := capsule_drive.on_the_line(setup)) is not None:
        aimed = capsule_drive.aims(velocity, setup.slider, step)
        act = capsule_drive.driven_along(assembly, aimed, setup.heading, tell)
    elif isinstance(problem.reference, PlaneReference) and setup.plane_velocity is not None:
        aimed = capsule_drive.aims_in_the_plane(problem.reference.motion.path, setup, step)
        act = capsule_drive.driven(assembly, aimed, step, tell)
    settle(assembly, step)
    seen: Seen
    if setup.in_plane:
        seen = capsule_reading.in_the_plane(setup, assembly), None
    else:
        seen = capsule_reading.on_the_line(setup, assembly)
    return _translated(assembly, act, seen, frozenset({"opening_rate"}))


def _beside(problem: CapsuleProblem, method: Method, step: float) -> Translation:
    setup = problem.setup
    if turns(setup):
        raise Unsupported("the side view has one line, and here the body turns")
    stand, act = standing(setup), None
    stand.assembly.space.iterations = iterations(problem, method)
    if (velocity := setup.relative_velocity) is not None:
        aimed = capsule_drive.aims(
            capsule_drive.on_an_axis(velocity), (along(setup, setup.slider), 0.0), step
        )
        act = capsule_drive.driven_along(stand.assembly, aimed, 0.0, capsule_drive.untold)
    settle(stand.assembly, step)
    seen: Seen
    if setup.in_plane:
        seen = capsule_pressure.in_the_plane(setup, stand), None
    else:
        seen = capsule_pressure.on_the_line(setup, stand)
    channels = frozenset({"heave", "tilt", "momentum_residual"})
    return _translated(stand.assembly, act, seen, channels)


def _translated(
    assembly: Assembly, act: capsule_drive.Act | None, seen: Seen, channels: frozenset[str]
) -> Translation:
    read, following = seen
    return Translation(assembly.space, read, act, channels, LIMITS, following)
