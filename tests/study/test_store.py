"""Stored studies come back as they were; comparisons and recommendations are made from them."""

from __future__ import annotations

import json
import math
import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import methods
from plumbob.engines.study import store
from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.measurement import ObservedError
from plumbob.engines.study.merged import merged
from plumbob.engines.study.provenance import provenance
from plumbob.engines.study.results import Study
from plumbob.engines.study.runner import run_study
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import scenes
from plumbob.models.scene import Quantity
from plumbob.reports.cli import main

SCENE = "cone-pendulum/deep-well"


@pytest.fixture(scope="module")
def study() -> Study:
    chosen = [replace(s, steps=(5e-3, 2e-3, 1e-3, 5e-4, 2e-4)) for s in scenes(SCENE)]
    return run_study(chosen, methods("mujoco/euler,ode/rk4,ode/dop853"))


def _save(study: Study, file: Path) -> int:
    return store.save(study, file)


def test_a_study_comes_back_as_it_was(study: Study, tmp_path: Path) -> None:
    number = _save(study, tmp_path / store.FILE)
    back = store.load(tmp_path / store.FILE, number)
    assert back is not None
    assert back.convergence == study.convergence
    assert back.costs == study.costs
    assert back.methods == study.methods
    assert [s.name for s in back.scenes] == [s.name for s in study.scenes]
    assert back.reference_step == study.reference_step


def test_the_studies_of_a_scene(study: Study, tmp_path: Path) -> None:
    file = tmp_path / store.FILE
    assert store.load(file) is None
    first = _save(study, file)
    _save(replace(study, scenes=(), convergence=(), costs={}, reference_step=math.nan), file)
    (found,) = store.studies_of(file, SCENE)
    assert found.convergence == study.convergence
    assert store.load(file, first) == found
    second = _save(replace(study, reference_step=2 * study.reference_step), file)
    assert store.studies_of(file, SCENE) == (found, store.load(file, second))
    assert store.load(file) == store.load(file, second) != found
    assert store.load(file, 99) is None
    assert store.studies_of(file, "nothing/like-it") == ()


OTHER = "linear-pendulum/overdamped"
PARTS = ("study", "result")


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A store with a study of two scenes, with an extra run."""
    file = tmp_path_factory.mktemp("stored") / store.FILE
    chosen = [replace(s, steps=(1e-2, 5e-3)) for s in (*scenes(SCENE), *scenes(OTHER))]
    asked = (ExtraRun(SCENE, "ode/rk4", 1e-3),)
    _save(run_study(chosen, methods("ode/rk4"), requests=lambda plan: asked), file)
    return file.read_bytes()


def _all_columns(file: Path) -> list[tuple[str, str]]:
    with closing(sqlite3.connect(file)) as held:
        return [
            (table, column)
            for table in PARTS
            for (_, column, *_) in held.execute(f"pragma table_info({table})").fetchall()
        ]


def test_any_change_of_a_stored_study_is_noticed(stored: bytes, tmp_path: Path) -> None:
    """One value of one row, whichever it is, and as slightly as can be; or a row less, or twice."""
    file = tmp_path / store.FILE
    file.write_bytes(stored)
    assert store.load(file) is not None
    changes = [
        f"update {table} set {column} = case typeof({column}) when 'text' then {column} || ' ' "
        f"when 'blob' then cast({column} || x'00' as blob) when 'null' then '' "
        f"when 'real' then {column} * (1 + 4e-16) else {column} + 1 end "
        f"where rowid = (select {which}(rowid) from {table})"
        for which in ("min", "max")
        for table, column in _all_columns(file)
    ]
    for table in PARTS:
        changes.append(f"delete from {table} where rowid = (select min(rowid) from {table})")
    assert len(changes) == 20
    for change in changes:
        file.write_bytes(stored)
        with closing(sqlite3.connect(file)) as held, held:
            assert held.execute(change).rowcount > 0
        with pytest.raises(ParameterError, match="is not as it was stored"):
            store.load(file)


def test_one_scene_is_read_though_another_is_damaged(stored: bytes, tmp_path: Path) -> None:
    file = tmp_path / store.FILE
    file.write_bytes(stored)
    before = store.studies_of(file, OTHER)
    with closing(sqlite3.connect(file)) as held, held:
        query = "update result set body = replace(body, '1', '2') where body like ?"
        assert held.execute(query, (f"%{SCENE}%",)).rowcount > 0
    assert store.studies_of(file, OTHER) == before != ()
    with pytest.raises(ParameterError, match=f"study 1, {SCENE}, is not as it was stored"):
        store.studies_of(file, SCENE)


def test_a_recording_comes_back_as_it_was() -> None:
    values = {"theta": np.array([0.1, math.nan]), "theta_dot": np.array([-0.0, math.inf])}
    run = Trajectory(
        np.array([0.0, 0.1]),
        values,
        {"contacts": np.array([3.0, 4.0])},
        steps=7,
        seconds=0.25,
        diverged_at=0.3,
        warnings=("NaN", "unstable"),
    )
    back = from_json(to_json(run), Trajectory)
    assert (back.steps, back.seconds, back.diverged_at) == (7, 0.25, 0.3)
    assert back.warnings == run.warnings
    np.testing.assert_array_equal(back.times, run.times)
    for part in ("observables", "channels"):
        assert getattr(back, part).keys() == getattr(run, part).keys()
        for name, array in getattr(run, part).items():
            np.testing.assert_array_equal(getattr(back, part)[name], array)


def test_a_file_that_is_no_store(tmp_path: Path) -> None:
    (tmp_path / store.FILE).write_text("what is this" * 200)
    with pytest.raises(ParameterError, match="store"):
        store.load(tmp_path / store.FILE)


@pytest.mark.parametrize(("schema", "which"), [(0, "an older"), (store.SCHEMA + 1, "a newer")])
def test_a_store_of_another_version_is_one_line(
    schema: int, which: str, study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / store.FILE
    _save(study, file)
    with closing(sqlite3.connect(file)) as opened:
        opened.execute(f"pragma user_version = {schema}")
    for words in (
        ["recommend", SCENE, "--error", "1e-6", "--out", str(tmp_path), "--stored"],
        ["report", str(tmp_path)],
        ["compare", str(file), str(file)],
        ["validate", "--scenes", SCENE, "--out", str(tmp_path)],  # before anything is run
    ):
        assert main(words) == 2
        captured = capsys.readouterr()
        assert captured.out == ""
        assert captured.err.count("\n") == 1
        assert which in captured.err


def test_every_kind_of_float_comes_back(study: Study, tmp_path: Path) -> None:
    found = study.convergence[0]
    first = found.measurements[0]
    odd = (math.nan, math.inf, -math.inf, 5e-324, 0.1 + 0.2, -0.0, 1.7976931348623157e308)
    errors = {
        str(i): ObservedError(value, value, 0.0, 1.0, {"a reason": value})
        for i, value in enumerate(odd)
    }
    strange = replace(first, errors=errors)
    kept = replace(study, convergence=(replace(found, measurements=(strange,)),))
    back = store.load(tmp_path / "new", _save(kept, tmp_path / "new"))
    assert back is not None
    assert repr(back.convergence) == repr(kept.convergence)


def test_every_scene_and_method_comes_back(study: Study, tmp_path: Path) -> None:
    # without scales of plans, each of which would have to be planned first
    interest = {scene.name: (Quantity("x", 1.0 / 3.0),) for scene in scenes()}
    whole = replace(study, scenes=scenes(), methods=methods(), observed={}, interest=interest)
    back = store.load(tmp_path / "new", _save(whole, tmp_path / "new"))
    assert back is not None
    assert back.methods == whole.methods
    assert back.scenes == whole.scenes
    assert back.interest == interest


def test_observables_and_scales_are_stored_where_a_study_has_none(
    study: Study, tmp_path: Path
) -> None:
    _save(replace(study, observed={}, interest={}), tmp_path / "new")
    back = store.load(tmp_path / "new")
    assert back is not None
    assert (back.observed, back.interest) == (study.observed, study.interest)


def test_compare_reports_what_changed(
    study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _save(study, tmp_path / "a")
    _save(study, tmp_path / "b")
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    assert "nothing has moved" in capsys.readouterr().out
    worse = []
    for c in study.convergence:
        runs = []
        for m in c.measurements:
            errors = {n: replace(e, largest=1.01 * e.largest) for n, e in m.errors.items()}
            runs.append(replace(m, errors=errors) if c.method == "ode/rk4" else m)
        worse.append(replace(c, measurements=tuple(runs)))
    _save(replace(study, convergence=tuple(worse)), tmp_path / "b")
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "b#2")]) == 1  # and so a verdict
    out = capsys.readouterr().out
    assert "ode/rk4: theta error at" in out
    assert "ode/rk4: verdict predicted -> off-prediction" in out
    assert "mujoco/euler: theta error" not in out
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "c")]) == 2


def test_recommend_answers_from_what_is_stored(
    study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _save(study, tmp_path / store.FILE)
    assert main(["recommend", SCENE, "--error", "1e-6", "--out", str(tmp_path), "--stored"]) == 0
    captured = capsys.readouterr()
    assert "use" in captured.out
    assert captured.err == ""
    assert main(["recommend", SCENE, "--error", "1e-30", "--out", str(tmp_path), "--stored"]) == 1
    assert "the best" in capsys.readouterr().out
    assert main(["recommend", SCENE, "--error", "-1", "--out", str(tmp_path), "--stored"]) == 2


def _asked(folder: Path, *words: str) -> list[str]:
    return ["recommend", SCENE, "--error", "1e-6", "--out", str(folder), "--stored", *words]


def test_recommend_leaves_other_versions_out_and_names_them(
    study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here = provenance("plumbob validate")
    old = replace(here, date="1999-12-31 00:00 UTC", versions={**here.versions, "mujoco": "2.0.0"})
    store.save(replace(study, provenance=old), tmp_path / store.FILE)
    assert main(_asked(tmp_path, "--json")) == 0
    captured = capsys.readouterr()
    answer = json.loads(captured.out)
    assert answer["choice"]["method"] == "ode/rk4"
    assert [c["method"].partition("/")[0] for c in answer["by_engine"]] == ["ode"]
    (line,) = captured.err.splitlines()
    assert "runs measured with mujoco 2.0.0 (1999-12-31 00:00 UTC) left out" in line
    assert main(_asked(tmp_path, "--engine", "mujoco")) == 1  # nothing of it counts


def test_a_later_smaller_study_changes_no_answer(
    study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store.save(replace(study, provenance=provenance("")), tmp_path / store.FILE)
    assert main(_asked(tmp_path, "--json")) == 0
    before = json.loads(capsys.readouterr().out)
    smaller = replace(
        study,
        methods=tuple(m for m in study.methods if m.name == "mujoco/euler"),
        convergence=tuple(
            replace(c, measurements=c.measurements[:2])
            for c in study.convergence
            if c.method == "mujoco/euler"
        ),
        costs={},
        provenance=provenance(""),
    )
    store.save(smaller, tmp_path / store.FILE)
    assert main(_asked(tmp_path, "--json")) == 0
    after = json.loads(capsys.readouterr().out)
    assert after["choice"] == before["choice"]
    assert after["by_engine"] == before["by_engine"]


def test_costs_are_the_median_ratio_to_the_reference_step(study: Study) -> None:
    key = (SCENE, "ode/rk4")
    slow = replace(study, reference_step=3.0 * study.reference_step)
    wild = replace(
        study, costs={k: replace(c, ratio=9.0 * c.ratio) for k, c in study.costs.items()}
    )
    one = only(study)
    both = merged([one, only(slow), only(wild)])
    assert both is not None
    assert both.costs[key].ratio == study.costs[key].ratio
    assert both.costs[key].ns_per_step == pytest.approx(one.costs[key].ratio * study.reference_step)
    changed = replace(one.scenes[0], parameters={**one.scenes[0].parameters, "gravity": 1.0})
    assert merged([one], changed) is None


def only(study: Study) -> Study:
    """What a study says of one scene."""
    return replace(
        study,
        scenes=tuple(s for s in study.scenes if s.name == SCENE),
        convergence=tuple(c for c in study.convergence if c.scene == SCENE),
        costs={key: cost for key, cost in study.costs.items() if key[0] == SCENE},
    )


HEAVY = ("scipy", "mujoco", "pymunk", "numpy_quaddtype", "plotly", "jinja2", "rich")
ASK = """
import sys
from plumbob.reports.cli import main
code = main(["recommend", sys.argv[1], "--error", "1e-6", "--stored", "--out", sys.argv[2]])
print(code, *sorted(set(sys.argv[3:]) & set(sys.modules)))
"""


def test_recommend_loads_no_engine(study: Study, tmp_path: Path) -> None:
    # Modules that an answer from a file needs not; systems and engines take a second to load.
    _save(study, tmp_path / store.FILE)
    answer = subprocess.run(
        [sys.executable, "-c", ASK, SCENE, str(tmp_path), *HEAVY],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "use " in answer.stdout
    assert answer.stdout.splitlines()[-1] == "0"


def test_a_users_settings_come_back_as_they_were(study: Study, tmp_path: Path) -> None:
    own = replace(
        study.methods[0],
        name="mujoco/mine",
        step_sizes=(2e-3, 1e-3),
        settings={"integrator": "euler", "contact": {"solref": (0.02, 1.0), "condim": 3}},
    )
    number = _save(replace(study, methods=(own,), convergence=(), costs={}), tmp_path / store.FILE)
    back = store.load(tmp_path / store.FILE, number)
    assert back is not None
    assert back.methods == (own,)
