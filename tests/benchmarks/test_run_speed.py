"""What plumbob's run of a scene in MuJoCo takes beside a bare loop of MuJoCo's own steps.

Run alone: pytest -s tests/benchmarks/test_run_speed.py
"""

import time

import mujoco
import pytest

from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.registry import method
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.benchmark_runs import in_turn

STEPS = 200_000  # a tenth of a second and more: the samples of a run are read within it
BARE = 1.1  # times a bare loop: samples, observables and tests of divergence are the rest


@pytest.mark.parametrize("name", ["cone-pendulum/rotating-base", "n-pendulum/triple"])
def test_a_run_takes_what_the_bare_loop_does(name, hold):
    simulation = compiled(
        case_of(scene(name)).lasting(STEPS * 1e-4), method("mujoco/euler"), 1e-4
    )
    model, start = simulation.model, simulation.data
    again = mujoco.MjData(model)

    def bare():
        mujoco.mj_copyData(again, model, start)
        begin = time.process_time()
        mujoco.mj_step(model, again, STEPS)
        return time.process_time() - begin

    def run():
        begin = time.process_time()
        simulation.run()
        return time.process_time() - begin

    hold(f"a run of {name} over the bare loop", in_turn(run, bare, 11), most=BARE)
