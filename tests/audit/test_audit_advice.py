"""what an audit advises: an option that a file takes, which does what was measured."""

from __future__ import annotations

import re
import time
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.audit import Audit, audited
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import OUT_OF_TIME, certified
from plumbob.engines.audit.steps import Cheapest, StepError, cheapest, held, observed_order
from plumbob.reports.view.audit.text import to_do
from plumbob.tests.audit.scenes_as_models import PENDULUM, ball, pendulum, ready


@pytest.fixture(name="found", scope="module")
def _found() -> Audit:
    model = ready(pendulum())
    return audited(model, script(model, duration=0.4), "rest", 20.0, time.process_time)


def choosing(found: Audit, *chosen: Cheapest) -> str:
    assert found.found is not None
    return to_do(replace(found, found=replace(found.found, cheapest=chosen)))


def test_the_option_said_does_what_was_measured(found: Audit) -> None:
    assert found.found is not None
    (option,) = re.findall(r"for 1 mm: (<option.*?>) \(×", to_do(found))
    text = re.sub("<option.*?/>", option, PENDULUM)
    other = own_model(mujoco.MjModel.from_xml_string(text), "rod")
    parts = round(found.script.period / other.step)
    again = held(other, found.script, found.reference, other.integrator, parts)
    best = next(c for c in found.found.cheapest if c.target == 1e-3)
    assert again.at(found.found.index) == best.error


def test_what_is_advised_depends_on_the_error(found: Audit) -> None:
    assert 1e-3 < found.error < 1e-2
    near = Cheapest(1e-3, "rk4", 0.005, 1e-4, 2.0)
    same = Cheapest(1e-2, "euler", 0.02, 9e-3, 0.5)
    assert choosing(found, same, near) == (
        'for 1 mm: <option timestep="0.005" integrator="RK4"/> (×2); '
        'enough for 1 cm: <option timestep="0.02"><flag refsafe="disable"/></option> (×0.5)'
    )
    assert choosing(found) == "no step that was run is reliably nearer"
    assert choosing(replace(found, clamped={"geom_solref": 2})).endswith(
        "; before another step, raise geom_solref to 20 ms in the file"
    )
    assert found.found is not None
    capped = replace(found.found, own=replace(found.found.own, remarks=("at its cap",)))
    assert "give the solver more iterations" in to_do(replace(found, found=capped))
    ended = replace(found.reference, why=f"{OUT_OF_TIME} at 0.25 s")
    short = replace(found.found, index=10, cheapest=(same, near))
    assert to_do(replace(found, found=short, reference=ended)).endswith(
        "(×2) up to 0.2 s; a larger --budget tells more"
    )
    as_large = Cheapest(1e-2, "implicitfast", 0.01, 9e-3, 0.6)
    assert choosing(found, as_large) == "no step that was run is reliably nearer"
    assert "enough for 1 cm" in choosing(found, replace(as_large, cost=0.4))
    assert to_do(replace(found, found=None)).startswith("try a shorter --duration")


def test_a_step_at_which_refsafe_would_clamp_is_written_with_its_flag() -> None:
    own = own_model(ball(), "ball")
    assert own.shortest == 0.02
    assert own.option("euler", 0.01) == '<option timestep="0.01"/>'
    wide = own.option("implicitfast", 0.011)
    assert wide == (
        '<option timestep="0.011" integrator="implicitfast"><flag refsafe="disable"/></option>'
    )
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{wide}</mujoco>")
    assert model.opt.disableflags == int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    assert own_model(pendulum(), "rod").shortest == 0.02


def run(step: float, error: float, cost: float, integrator: str = "euler") -> StepError:
    return StepError(integrator, step, 1, np.array([0.0, error]), np.zeros(2), "rod", cost)


def test_a_step_is_cheapest_only_where_every_smaller_one_is_as_good(found: Audit) -> None:
    known = replace(found.reference, uncertainty=np.array([0.0, 1e-6]))
    steps = [run(4.0, 5e-4, 1.0), run(2.0, 3e-3, 2.0), run(1.0, 8e-4, 4.0), run(0.5, 4e-4, 8.0)]
    best = cheapest(steps, steps[1], known, 1, 1e-3)
    assert best == Cheapest(1e-3, "euler", 1.0, 8e-4, 2.0)
    assert cheapest(steps[:2], steps[1], known, 1, 1e-3) is None
    assert cheapest(steps, steps[1], known, 1, 4e-6) is None  # known to a quarter of it only


def test_the_worst_body_is_the_one_that_is_furthest_off() -> None:
    """A rod on a rod: the second one has the larger error."""
    text = PENDULUM.format(integrator="Euler").replace(
        "</body>", '<body name="tip" pos=".5 0 0"><geom size=".02" pos=".2 0 0"/></body></body>'
    )
    model = ready(mujoco.MjModel.from_xml_string(text))
    motion = script(model, duration=0.2)
    known = certified(model, motion, 20.0, time.process_time)
    assert held(model, motion, known, "euler", 2).worst == "tip"


def test_an_order_is_that_of_errors_that_the_reference_resolves(found: Audit) -> None:
    """Errors of second order above what is known; below that they go up and down."""
    known = replace(found.reference, uncertainty=np.array([0.0, 1e-6]))
    steps = [run(2.0**-k, 4.0**-k, 1.0) for k in range(8)]
    steps += [run(2.0**-k, 4e-6, 1.0) for k in range(9, 12)]
    order = observed_order(steps, known, 1)
    assert order is not None
    assert (order.low, order.slope, order.high) == pytest.approx((2.0, 2.0, 2.0))
