"""What engines' own readers of model files take over, as `plumbob models check` tells it."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from plumbob.engines.registry import find_engine, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study import store
from plumbob.engines.study.model_reading import EVERY_FIELD, ModelReading
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import scenes as find_scenes
from plumbob.reports.analyses.engines.readers import KNOWN, READERS, requests
from plumbob.reports.cli import main
from plumbob.reports.judge.model_readers import compared
from plumbob.tests.support.declared import finding

ALL = (
    *("gravity", "timestep", "mass", "inertia", "armature", "damping", "stiffness"),
    *("frictionloss", "friction", "solref", "solimp", "gear"),
)
MODEL, STEP = "free_body/free_body.xml", ("timestep", "")


def test_what_each_reader_takes_over(capsys):
    """Of a model that has every field; what is known of each is on the pages, too."""
    assert main(["models", "check", "--json"]) == 0
    readers = {reader["engine"]: reader for reader in json.loads(capsys.readouterr().out)}
    assert set(readers) == {"mujoco", *(e for e in KNOWN if installed(find_engine(e)))}
    for engine, found in readers.items():
        _held(engine, found)


def _held(engine, found):
    """The fields that a reader takes over are the known ones, and the others are named."""
    assert found["refuses"] == "", engine
    read = ALL if engine == "mujoco" else KNOWN[engine].fields
    assert tuple(found["read"]) == read
    dropped = tuple(f for f in ALL if f not in read)
    assert tuple(found["dropped"] or ()) == dropped


STATED = {("gravity", ""): (0.0, 0.0, -9.81), ("mass", "arm"): (1.7,), ("friction", "bob"): (0.6,)}


def test_what_is_dropped_is_said_with_what_is_there_instead():
    given = {("gravity", ""): (0.0, 0.0, -9.81), ("mass", "arm"): (1.70004,)}
    found = compared("other", STATED, given)
    assert found.read == ("gravity",)
    assert found.dropped == {"mass": "arm: 1.7 for 1.7", "friction": ""}
    by_body = {**STATED, ("friction", "arm"): (0.6,)}
    del by_body["friction", "bob"]
    assert compared("other", STATED, by_body).dropped == {}
    assert compared("other", STATED, STATED, ("gravity",)).read == ("mass", "friction")


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A study of a scene that asks for readings, as it is stored; with DART, whose reader is played
    by MuJoCo's."""
    file = tmp_path_factory.mktemp("study") / "studies.sqlite3"
    scenes = find_scenes("free-body/symmetric")
    short = [replace(scene, duration=0.01, steps=(1e-3,)) for scene in scenes]
    chosen = find_methods("mujoco/rk4,dart/default")
    found = run_study(short, chosen, timed=False, requests=requests)
    own = found.answer(ModelReading("mujoco", MODEL))
    assert STEP in own.fields
    played = {
        asked: found.extras[replace(asked, engine="mujoco")]
        for asked in found.extras
        if isinstance(asked, ModelReading)
    }
    store.save(replace(found, extras={**found.extras, **played}), file)
    stored = store.load(file)
    assert stored is not None
    return stored


def _tables(study):
    """The finding's tables: of each row the texts beside its name."""
    shown = finding(READERS, study)
    return [{r[0].text: tuple(cell.text for cell in r[1:]) for r in t.rows} for t in shown.tables]


def test_a_page_shows_what_the_study_stored_of_readers(study):
    fields, models = _tables(study)
    assert tuple(fields) == ALL
    assert fields["mass"][:2] == ("read", "read")  # MuJoCo and who is played by it
    assert models == {MODEL: ("none of 3 fields", "none of 3 fields")}
    shown = finding(READERS, study)
    assert "Drake 1.51.1, Pinocchio 4.1.0, PyBullet 3.2.7" in shown.paragraphs[-1]  # not read
    assert "also reads gravity" in shown.paragraphs[1]  # unlike what is known of DART


def test_another_stored_number_is_another_page(study):
    wrong = dict(study.extras)
    for model in (EVERY_FIELD, MODEL):
        asked = ModelReading("dart", model)
        read = study.answer(asked)
        off = (
            replace(n, values=(1.01 * n.values[0],)) if n.field == "mass" else n
            for n in read.numbers
        )
        wrong[asked] = replace(read, numbers=tuple(off))
    fields, models = _tables(replace(study, extras=wrong))
    assert fields["mass"][:2] == ("read", "not read; arm: 1.717 for 1.7")
    assert fields["inertia"] == _tables(study)[0]["inertia"]
    assert models[MODEL] == ("none of 3 fields", "mass")


@pytest.mark.parametrize("text", ["", "<mujoco>", "<mujoco><option gravity='a'/></mujoco>"])
def test_what_is_no_model_is_bad_input(text, tmp_path, capsys):
    (file := tmp_path / "my.xml").write_text(text, "utf-8")
    assert main(["models", "check", str(file)]) == 2
    said = capsys.readouterr().err
    assert said.startswith("plumbob: FILE = ")
    assert said.count("\n") == 1
