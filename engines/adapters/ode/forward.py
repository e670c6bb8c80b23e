"""Forward sensitivities. Of an equation x'' = f(t, x, x'; p), the derivative s of x by a parameter
p obeys

    s'' = f_x s + f_v s' + f_p                                                                  (1)

(Hairer, Norsett and Wanner 1993, Solving Ordinary Differential Equations I, I.14), and is stepped
together with x. The derivatives of f come from stencils of order 8, whose errors are negligible
beside the error of the step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.sensitivities.neighbours import CENTRAL_OFFSETS, Neighbours
from plumbob.engines.adapters.equation import Equation
from plumbob.engines.adapters.ode.simulation import simulation_of
from plumbob.engines.adapters.turning import TurningEquation
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import find_builder
from plumbob.engines.trajectory import ByName
from plumbob.models.gradient import NEIGHBOUR_DISTANCE, Number

SPACING = 5e-3  # spacing of the stencil along s, in units of the state
OFFSETS = np.array(CENTRAL_OFFSETS, dtype=np.float64)


def forward(number: Number, method: Method, step: float) -> ByName:
    """The derivatives of the angle and of its rate at the end of a run by `number`; raises
    Unsupported and ParameterError."""
    build = find_builder("ode", number.case.system).build
    offsets = OFFSETS * NEIGHBOUR_DISTANCE * number.size
    try:
        problems = tuple(number.problem(number.value + float(offset)) for offset in offsets)
    except ParameterError as error:
        raise Unsupported(str(error)) from None
    equations = Neighbours(problems, offsets).each(lambda problem: build(problem, method))
    if isinstance(equations.here, TurningEquation):
        raise Unsupported("a step turns the attitude, and eq. 1 does not hold for turns")
    if np.ndim(equations.here.position):
        raise Unsupported("eq. 1 is stepped only with one degree of freedom")
    duration = number.case.scene.duration
    run = simulation_of(_with_sensitivity(equations), method, step, duration).run()
    if run.diverged_at is not None:
        raise Unsupported(f"the run diverged after {run.diverged_at:.3g} s")
    names = "theta", "theta_dot"
    return {name: float(run.observables[f"s_{name}"][-1]) for name in names}


def _with_sensitivity(equations: Neighbours[Equation]) -> Equation:
    """The equation of (x, s), from the equations at neighbouring values of the parameter."""
    here = equations.here
    stencil = Neighbours(tuple(OFFSETS * SPACING), OFFSETS * SPACING)

    def acceleration(t: float, x: Array, v: Array) -> Array:
        """(x'', s'') by eq. 1."""
        (angle, s) = x.tolist()
        (rate, s_dot) = v.tolist()
        by_parameter = equations.slope(lambda other: other.acceleration(t, angle, rate))
        size = max(abs(s), abs(s_dot)) or 1.0

        def along_sensitivity(offset: float) -> Any:
            """The acceleration in a state that is moved along the sensitivity."""
            moved_angle = angle + offset * s / size
            moved_rate = rate + offset * s_dot / size
            return here.acceleration(t, moved_angle, moved_rate)

        by_state = size * stencil.slope(along_sensitivity)
        return np.array([here.acceleration(t, angle, rate), by_state + by_parameter])

    position_slope = equations.slope(lambda other: other.position)
    rate_slope = equations.slope(lambda other: other.rate)
    return Equation(
        acceleration,
        position=np.array([here.position, position_slope]),
        rate=np.array([here.rate, rate_slope]),
        speed=here.speed,
        limits=here.limits,
        names=("theta", "s_theta"),
        rate_names=("theta_dot", "s_theta_dot"),
        size=here.size,
    )
