"""What the MuJoCo adapter costs beside a bare loop, and what disabled pipeline stages save.

Both sides of a ratio are timed in turn, by processor time, and compared turn by turn, so that a
slower machine or a busy one moves them together.
"""

import time

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.engines.adapters.mujoco.simulation import compiled
from plumbob.engines.adapters.mujoco.trimming import trimming
from plumbob.engines.method import meant
from plumbob.tests.support.benchmark_runs import in_turn
from plumbob.tests.support.cone_scene import SYSTEM, scene

STEPS = 5000  # of 1e-4 s: 501 samples, every tenth step and the start
METHODS = {method.name: method for method in ENGINE.methods}


def bare(simulation):
    """Processor time [s] of the loop that anyone would write: ten steps in C, then record."""
    model, data = simulation.model, simulation.data
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = simulation.translation.qpos, simulation.translation.qvel
    recorded = np.empty((STEPS // 10, 3))
    begin = time.thread_time()
    for row in recorded:
        mujoco.mj_step(model, data, nstep=10)
        row[:] = data.time, data.qpos[1], data.qvel[1]
    return time.thread_time() - begin


def adapted(simulation):
    """Processor time [s] of the adapter's whole run, from reset to trajectory."""
    begin = time.thread_time()
    simulation.run()
    return time.thread_time() - begin


@pytest.mark.parametrize("name", ["mujoco/euler", "mujoco/rk4"])
def test_adapter_costs_little(name, hold):
    # Measured: 0.97 to 1.03, as recording is done in C.
    simulation = compiled(SYSTEM.case(scene()), METHODS[name], 1e-4)
    turns = in_turn(lambda: adapted(simulation), lambda: bare(simulation), 41)
    hold(f"{name}: adapter over bare loop", turns, most=1.1)


@pytest.mark.parametrize("name", [m.name for m in METHODS.values() if meant(m, scene())])
def test_trimming_saves_and_changes_nothing(name, hold):
    # Measured: 0.61 to 0.71 on every integrator. 0.9 would mean that a stage is enabled again.
    found = [trimming(SYSTEM.case(scene()), METHODS[name]) for _ in range(5)]
    assert all(one.identical for one in found)
    hold(f"{name}: trimmed over all in", [m.ns_trimmed / m.ns_default for m in found], most=0.9)
