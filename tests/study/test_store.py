"""Stored studies come back as they were; comparisons and recommendations are made from them."""

import json
import math
import sqlite3
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import methods
from plumbob.engines.study import store
from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.measurement import ObservedError
from plumbob.engines.study.provenance import provenance
from plumbob.engines.study.runner import run_study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import scenes
from plumbob.reports.cli import main
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import bits

SCENE = "cone-pendulum/deep-well"


@pytest.fixture(scope="module")
def study():
    chosen = [replace(s, steps=(5e-3, 2e-3, 1e-3, 5e-4, 2e-4)) for s in scenes(SCENE)]
    return run_study(chosen, methods("mujoco/euler,ode/rk4,ode/dop853"))


def _kept(study, file):
    """What comes back of a study that is stored."""
    back = store.load(file, save(study, file))
    assert back is not None
    return back


def test_a_study_comes_back_as_it_was(study, tmp_path):
    back = _kept(study, tmp_path / store.FILE)
    assert replace(back, scenes=study.scenes, extras=study.extras) == study


def test_the_newest_study_of_a_scene(study, tmp_path):
    file = tmp_path / store.FILE
    assert store.load(file) is None
    first = save(study, file)
    none = replace(study, scenes=(), convergence=(), costs={}, reference_step=math.nan)
    last = save(none, file)
    found = store.load(file, scenes=[SCENE])
    assert found.convergence == study.convergence
    # As texts: a number that is none equals itself in no field.
    newest, again = repr(store.load(file)), repr(store.load(file, last))
    assert repr(found) == repr(store.load(file, first))
    assert newest == again != repr(found)
    assert store.load(file, 99) is None
    assert store.load(file, scenes=["nothing/like-it"]) is None


OTHER = "linear-pendulum/overdamped"


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A store with a study of two scenes, with an extra run."""
    file = tmp_path_factory.mktemp("stored") / store.FILE
    chosen = [replace(s, steps=(1e-2, 5e-3)) for s in (*scenes(SCENE), *scenes(OTHER))]
    asked = (ExtraRun(SCENE, "ode/rk4", 1e-3),)
    save(run_study(chosen, methods("ode/rk4"), requests=lambda plan: asked), file)
    return file.read_bytes()


def _all_columns(file):
    with closing(sqlite3.connect(file)) as held:
        return [
            column for _, column, *_ in held.execute("pragma table_info(result)").fetchall()
        ]


def test_any_change_of_a_stored_study_is_noticed(stored, tmp_path):
    """One value of one row, whichever it is, and as slightly as can be; or a row less, or twice."""
    file = tmp_path / store.FILE
    file.write_bytes(stored)
    assert store.load(file) is not None
    changes = [
        f"update result set {column} = case typeof({column}) when 'text' then {column} || ' ' "
        f"else {column} + 1 end where rowid = (select {which}(rowid) from result)"
        for which in ("min", "max")
        for column in _all_columns(file)
    ]
    changes += [
        f"delete from result where rowid = (select {which}(rowid) from result)"
        for which in ("min", "max")
    ]
    assert len(changes) == 10
    for change in changes:
        file.write_bytes(stored)
        with closing(sqlite3.connect(file)) as held, held:
            assert held.execute(change).rowcount > 0
        with pytest.raises(ParameterError, match="is not as it was stored"):
            store.load(file)


def test_a_recording_comes_back_as_it_was():
    values = {"theta": np.array([0.1, math.nan]), "theta_dot": np.array([-0.0, math.inf])}
    channels = {"contacts": np.array([3.0, 4.0])}
    times = np.array([0.0, 0.1])
    said = ("NaN", "unstable")
    run = Trajectory(times, values, channels, 7, 0.25, diverged_at=0.3, warnings=said)
    assert bits(from_json(to_json(run), Trajectory)) == bits(run)


def test_every_kind_of_float_comes_back(study, tmp_path):
    found = study.convergence[0]
    odd = (math.nan, math.inf, -math.inf, 5e-324, 0.1 + 0.2, -0.0, 1.7976931348623157e308)
    errors = {str(x): ObservedError(x, x, 0.0, 1.0, {"a reason": x}) for x in odd}
    strange = replace(found, measurements=(replace(found.measurements[0], errors=errors),))
    kept = replace(study, convergence=(strange,))
    assert repr(_kept(kept, tmp_path / "new").convergence) == repr(kept.convergence)


def test_recommend_names_stored_runs_of_other_versions(study, tmp_path, capsys):
    here = provenance("plumbob validate")
    old = replace(here, versions={**here.versions, "mujoco": "2.0.0"})
    save(replace(study, provenance=old), tmp_path / store.FILE)
    asked = [
        "recommend",
        SCENE,
        "--error",
        "1e-6",
        "--out",
        str(tmp_path),
        "--stored",
        "--json",
    ]
    assert main(asked) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["study"]["versions"]["mujoco"] == "2.0.0"
    (line,) = captured.err.splitlines()
    assert line.startswith("plumbob: the stored runs are of mujoco 2.0.0, here ")
