"""What a sweep gives up is far beyond what its runs need, and ends while somebody waits."""

import time

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.ode import simulation
from plumbob.engines.box import EXACT_MOTION_SECONDS, Side, box
from plumbob.engines.registry import method
from plumbob.engines.sweep import sweep as sweeps
from plumbob.models.registry import case_of, scene

WAITED = 2 * 3600.0  # [s]: a chunk that hangs costs no night


@pytest.mark.parametrize(("methods", "steps"), [(1, 1), (2, 3)])
def test_a_chunk_may_give_up_the_exact_motion_at_each_place(methods, steps, monkeypatch):
    """A limit of a tenth loses its results, and one of ten times hides that it hangs."""
    tasks = []

    def none(given, *_, **__):
        tasks.extend(given)
        return ()

    monkeypatch.setattr(sweeps, "results", none)
    chosen = [method("mujoco/euler"), method("mujoco/rk4")][:methods]
    around = box("n-pendulum", {}, [Side("gravity", 1.0, 20.0)])
    asked = sweeps.sweep_of(around, (1000,), chosen, [1e-3 / (k + 1) for k in range(steps)])
    with pytest.raises(ParameterError, match="nothing was run"):
        sweeps.sweep(asked, {}, lambda number, chunk: None)
    assert asked.chunk * EXACT_MOTION_SECONDS < tasks[0].limit < WAITED


def test_a_solver_is_given_up_far_beyond_what_a_scene_needs(monkeypatch):
    """No scene needs as many evaluations at the smallest tolerance as this one, and no solver takes
    as long for one as Radau."""
    case = case_of(scene("simple-pendulum/rotating-slow"))
    most = simulation.MOST_EVALUATIONS
    needed = simulation.prepared(case, method("ode/lsoda"), 1e-12).run()
    assert 10 * needed.steps < most
    begun = time.process_time()
    slowest = simulation.prepared(case, method("ode/radau"), 1e-5).run()
    assert (time.process_time() - begun) / slowest.steps * most < 120.0  # [s]
    monkeypatch.setattr(simulation, "MOST_EVALUATIONS", needed.steps // 2)
    given_up = simulation.prepared(case, method("ode/lsoda"), 1e-12).run()
    assert f"given up after its budget of {needed.steps // 2} evaluations" in str(given_up)
