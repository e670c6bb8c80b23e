"""What engines' own readers of model files take over, as `plumbob models check` tells it."""

import json
from dataclasses import replace

import pytest

from plumbob.engines.registry import find_engine, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study import store
from plumbob.engines.study.model_reading import ModelReading
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import scenes as find_scenes
from plumbob.reports.analyses.engines.readers import KNOWN, READERS, requests
from plumbob.reports.cli import main
from plumbob.reports.judge.model_readers import compared
from plumbob.tests.support.declared import finding
from plumbob.tests.support.stored import save

ALL = (
    *("gravity", "timestep", "mass", "inertia", "armature", "damping", "stiffness"),
    *("frictionloss", "friction", "solref", "solimp", "gear"),
)


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
    read = ALL if engine == "mujoco" else KNOWN[engine].read
    assert tuple(found["read"]) == read
    dropped = tuple(f for f in ALL if f not in read)
    assert tuple(found["dropped"] or ()) == dropped


STATED = {
    ("gravity", ""): (0.0, 0.0, -9.81),
    ("mass", "arm"): (1.7,),
    ("friction", "bob"): (0.6,),
}


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
    played = {PLAYED: found.extras[ModelReading("mujoco")]}
    save(replace(found, extras={**found.extras, **played}), file)
    stored = store.load(file)
    assert stored is not None
    return stored


PLAYED = ModelReading("dart")


def _fields(study):
    """The finding's table: of each field the texts beside it."""
    (table,) = finding(READERS, study).tables
    return {row[0].text: tuple(cell.text for cell in row[1:]) for row in table.rows}


def test_a_page_shows_what_the_study_stored_of_readers(study):
    fields = _fields(study)
    assert tuple(fields) == ALL
    assert fields["mass"][:2] == ("read", "read")  # MuJoCo and who is played by it
    shown = finding(READERS, study)
    assert "Drake 1.51.1, Newton 1.8.0, Pinocchio 4.1.0" in shown.paragraphs[-1]  # not read
