"""Derivatives of a pendulum's run by Drake's AutoDiffXd: the discrete plant stepped with numbers
that carry their derivative, from a context in which state and parameters have it."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.analysis import Simulator_

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.drake.scenes import advancing, assembled
from plumbob.engines.adapters.hinged_body import hinged_body
from plumbob.engines.adapters.own_derivatives import nudged
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.sampling import step_count
from plumbob.engines.trajectory import ByName
from plumbob.models.gradient import Number


def derivatives(number: Number, method: Method, step: float) -> ByName:
    """Derivatives of the angle and its rate at the end; raises Unsupported."""
    cases, apart = nudged(number)
    low, here, high = (hinged_body(case) for case in cases)
    if method.control == "tolerance":
        raise Unsupported("AutoDiffXd is stepped in discrete plants alone here")
    if (low.forcing, low.gravity) != (high.forcing, high.gravity):
        raise Unsupported(f"{number.name} is no parameter in a context of Drake's")
    plants = [assembled(body, {"time_step": step}, body.pull) for body in (low, here, high)]
    diagram = plants[1].diagram.ToAutoDiffXd()
    context = diagram.CreateDefaultContext()
    context.SetTimeStateAndParametersFrom(plants[1].start())
    _move(context, [plants[0].start(), plants[2].start()], apart)
    simulator = Simulator_[AutoDiffXd](diagram, context)
    simulator.Initialize()
    advancing(simulator, step)(0, step_count(number.case.scene.duration, step))
    end = simulator.get_context().get_discrete_state_vector().CopyToVector()
    last = {"theta": end[len(end) // 2 - 1], "theta_dot": end[-1]}
    return {name: float(value.derivatives()[0]) for name, value in last.items()}


def _move(context: Any, starts: list[Any], apart: float) -> None:
    """Give the numbers of a context their derivatives, by contexts on both sides."""
    for i in range(context.num_numeric_parameter_groups()):
        rows = [start.get_numeric_parameter(i).CopyToVector() for start in starts]
        held = context.get_mutable_numeric_parameter(i)
        held.SetFromVector(_moving(held.CopyToVector(), rows, apart))
    states = [start.get_discrete_state_vector().CopyToVector() for start in starts]
    values = context.get_discrete_state_vector().CopyToVector()
    context.SetDiscreteState(_moving(values, states, apart))


def _moving(values: Any, sides: list[Array], apart: float) -> Any:
    """Numbers with their derivatives, shape (n,), by their values on both sides."""
    slopes = (sides[1] - sides[0]) / apart
    return np.array(
        [AutoDiffXd(v.value(), np.array([s])) for v, s in zip(values, slopes, strict=True)]
    )
