"""A cluster on this machine: results are those of one process, and a killed worker loses none."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.box import Side, box
from plumbob.engines.registry import method, methods
from plumbob.engines.study.provenance import provenance
from plumbob.engines.study.runner import run_study
from plumbob.engines.sweep import cluster as module
from plumbob.engines.sweep.cluster import cluster
from plumbob.engines.sweep.sweep import sweep, sweep_of
from plumbob.models.registry import matching_scenes


@pytest.fixture(scope="module")
def workers():
    """Two workers, a process each."""
    distributed = pytest.importorskip(
        "distributed", reason="the extra `distributed` is missing"
    )
    settings = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(**settings) as found:
        yield found


@pytest.mark.long
def test_a_worker_that_is_killed_loses_nothing(workers):
    headings = box("capsule-line", {}, [Side("heading", 0.0, 6.0)])
    asked = replace(sweep_of(headings, [40], [method("mujoco/euler")], [1e-3]), chunk=4)
    kept = []

    def keep(number, chunk):
        kept.append(number)
        if len(kept) == 2:
            workers.workers[0].process.process._process.kill()

    with cluster(workers.scheduler_address) as (executor, count):
        assert count == 2
        found = sweep(asked, {}, keep, count, executor)
    assert sorted(kept) == list(range(10))
    alone = sweep(asked, {}, lambda number, chunk: None)
    assert np.array_equal(found.errors, alone.errors)


@pytest.mark.long
def test_a_study_on_a_cluster_is_the_local_one_to_the_bit(workers):
    asked = (
        matching_scenes("simple-pendulum/free-small"),
        methods("mujoco/rk4,ode/dop853"),
        "quick",
    )
    with cluster(workers.scheduler_address) as (executor, count):
        far = run_study(*asked, count, executor, timed=False)
    near = run_study(*asked, 1, timed=False)
    errors = [[m.errors for c in of.convergence for m in c.measurements] for of in (far, near)]
    assert errors[0] == errors[1]


@pytest.mark.long
def test_workers_with_other_versions_are_refused(workers, monkeypatch):
    older = replace(_now, versions=_older)
    monkeypatch.setattr("plumbob.engines.study.provenance.provenance", lambda command: older)
    with pytest.raises(ParameterError, match=r"have mujoco 2\.0\.0, as here, not"):
        module.cluster(workers.scheduler_address).__enter__()


@pytest.mark.long
def test_nothing_at_an_address_is_one_line(monkeypatch):
    pytest.importorskip("distributed", reason="the extra `distributed` is missing")
    monkeypatch.setattr(module, "SCHEDULER_WAIT", 0.5)
    with pytest.raises(ParameterError, match="the address of one that runs"):
        module.cluster("tcp://127.0.0.1:9").__enter__()


_now = provenance("")
_older = {**_now.versions, "mujoco": "2.0.0"}
