"""Stored studies come back as they were; comparisons and recommendations are made from them."""

import json
import math
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import method, methods
from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import measured_into
from plumbob.engines.study.codec import KINDS, from_json, stored_class, to_json
from plumbob.engines.study.cost import SceneCosts
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.measurement import ObservedError
from plumbob.engines.study.provenance import provenance
from plumbob.engines.study.request import Request, RunRequest
from plumbob.engines.study.results import TaskResult
from plumbob.engines.study.runner import run_study
from plumbob.engines.study.store_file import reading_connection
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import matching_scenes
from plumbob.reports.cli import main
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import bits, made_up

SCENE = "cone-pendulum/deep-well"


@pytest.fixture(scope="module")
def study():
    chosen = [replace(s, steps=(5e-3, 2e-3, 1e-3, 5e-4, 2e-4)) for s in matching_scenes(SCENE)]
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
    chosen = [
        replace(s, steps=(1e-2, 5e-3))
        for s in (*matching_scenes(SCENE), *matching_scenes(OTHER))
    ]
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


CHANGES = (
    "study = 9",
    "key = key || ' '",
    "body = body || ' '",
    "body = cast(x'7bff' as text)",  # no UTF-8
    "digest = 'x'",
)


@pytest.mark.parametrize("of", ["key = 'study'", "key not in ('study', 'plan')"])
@pytest.mark.parametrize("change", CHANGES)
def test_damage_of_a_study_is_its_own(change, of, tmp_path, capsys):
    """Found before a new one is measured, with advice that works."""
    file = tmp_path / store.FILE
    made = [
        made_up([(method("ode/rk4"), (1e-2, 1e-3), lambda h, p=p: h**p)]) for p in (4, 5, 6)
    ]
    for one in made[:2]:
        save(one, file)
    with closing(sqlite3.connect(file)) as held, held:
        held.execute(
            f"update result set {change} where rowid = "
            f"(select min(rowid) from result where study = 1 and {of})"
        )
    notes = []
    with measured_into(file, note=notes.append) as kept:
        assert any("study 1" in note and "measure again" in note for note in notes)
        assert kept.number == 0  # nothing is begun yet
    assert _same(file, 2, made[1])
    with pytest.raises(ParameterError, match=r"study 1.* is not as it was stored"):
        store.load(file, 1)
    with closing(sqlite3.connect(file)) as held, held:
        held.execute(f"update result set {CHANGES[2]} where study = 2 and {of}")
    assert main(["compare", str(file), str(file)]) == 2
    assert "is not as it was stored: measure again" in capsys.readouterr().err
    number = save(made[2], file)  # the advice: measure again
    assert _same(file, None, made[2])
    assert main(["compare", f"{file}#{number}", str(file)]) == 0


def _same(file, number, study):
    return repr(store.load(file, number).convergence) == repr(study.convergence)


EARLIER = Path(__file__).parent / "study_of_schema_10.sql"
# Kinds that came after that study
LATER = {"DrawingRequest", "LoopSearch", "SceneDrawing", "StepRun"}


def test_a_study_of_an_earlier_version_is_read(tmp_path):
    """Its kinds are places in the code of that day, all that can be stored; what it holds is read
    by json alone."""
    file = tmp_path / store.FILE
    with closing(sqlite3.connect(file)) as held:
        held.executescript(EARLIER.read_text("utf-8"))
        bodies = [json.loads(b) for (b,) in held.execute("select body from result") if b]
    kinds = {place for body in bodies for place in body.get("kinds", {}).values()}
    assert {place.rpartition(".")[2] for place in kinds} == set(KINDS) - LATER
    study = store.load(file)
    runs = {"answer": "study.convergence.ConvergenceStudy"}
    (errors,) = (body["answer"] for body in bodies if body.get("kinds") == runs)
    (read,) = study.convergence
    for run, known in zip(read.measurements, errors["measurements"], strict=True):
        assert run.step == known["step"]
        assert run.errors["theta"].largest == known["errors"]["theta"]["largest"]
    assert len(study.extras) == len([body for body in bodies if body.get("request")]) == 7
    assert [analysed.numbers for analysed in study.analyses] == [{"x": (1.5, 2)}]
    with reading_connection(file) as held:
        (single,) = store.stored_results(held, 2, ["a run"], TaskResult).values()
    assert single.answer.step == 0.02


def test_every_kind_of_result_has_a_name_of_its_own():
    kinds = [stored_class(name) for name in KINDS]
    requests = [kind for kind in kinds if issubclass(kind, Request)]
    assert set(requests) == set(_below(Request)) - {RunRequest}
    answers = {get_args(base)[0] for kind in requests for base in kind.__orig_bases__}
    assert answers <= set(kinds)
    # A class that has moved is read by its old name.
    assert stored_class("a.place.of.old.SceneCosts") is SceneCosts


def _below(kind):
    """The classes of plumbob that inherit from one."""
    for one in kind.__subclasses__():
        if one.__module__.startswith("plumbob.engines"):
            yield one
        yield from _below(one)


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
    one = found.measurements[0]
    (name, *_) = one.errors  # a store whose errors are of no observable is refused
    errors = ({name: ObservedError(x, x, 0.0, 1.0, {"a reason": x})} for x in odd)
    strange = replace(found, measurements=tuple(replace(one, errors=of) for of in errors))
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
