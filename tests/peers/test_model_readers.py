"""What engines' own readers of model files take over, as `plumbob models check` tells it."""

import json
from dataclasses import replace

import pytest

from plumbob.engines.registry import find_engine, installed
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study import store
from plumbob.engines.study.model_reading import ModelReading, dropped
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import scenes as find_scenes
from plumbob.reports.analyses.engines.readers import KNOWN, READERS, requests
from plumbob.reports.cli import main
from plumbob.reports.judge.model_readers import compared_reading
from plumbob.tests.support.declared import finding
from plumbob.tests.support.stored import save

ALL = (
    *("gravity", "timestep", "mass", "inertia", "armature", "damping", "stiffness"),
    *("frictionloss", "friction", "solref", "solimp", "gear", "kp", "kv"),
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
    found = compared_reading("other", STATED, given)
    assert found.read == ("gravity",)
    assert found.dropped == {"mass": "arm: 1.7 for 1.7", "friction": ""}
    by_body = {**STATED, ("friction", "arm"): (0.6,)}
    del by_body["friction", "bob"]
    assert compared_reading("other", STATED, by_body).dropped == {}
    assert compared_reading("other", STATED, STATED, ("gravity",)).read == ("mass", "friction")


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


UNNAMED = """<mujoco model="unnamed"><compiler angle="radian"/><worldbody>
<geom type="plane" size="1 1 1" friction="0.9 0.01 0.001"/>
<body pos="0 0 1"><inertial pos="0 0 -0.1" mass="1.5" diaginertia="0.11 0.12 0.13"/>
<joint type="hinge" axis="0 1 0" damping="0.5" stiffness="2" armature="0.2"/>
<geom size="0.1" friction="0.3 0.01 0.001"/>
<body name="arm" pos="0 0 -0.5"><inertial pos="0 0 -0.1" mass="2" diaginertia="0.21 0.22 0.23"/>
<joint type="hinge" axis="0 1 0" damping="0.6"/>
<geom size="0.1" friction="0.4 0.01 0.001"/></body></body>
<body pos="1 0 1"><inertial pos="0 0 -0.1" mass="3" diaginertia="0.31 0.32 0.33"/>
<joint name="slide" type="slide" damping="0.7"/></body></worldbody>
<actuator><motor joint="slide" gear="5"/><position joint="slide" kp="30" kv="4"/></actuator>
</mujoco>"""
TAKEN = ("mass", "inertia", "armature", "damping", "stiffness", "friction", "gear", "kp", "kv")
OF_UNNAMED = {  # what each reader drops of it
    "dart": {
        "mass": "body 3: 1 for 3",  # which has no geoms
        "inertia": "body 1: 1 1 1 for 0.11 0.12 0.13",
        "armature": "",
        "stiffness": "joint 0 of body 1: 0 for 2",
        **dict.fromkeys(("gear", "kp", "kv"), ""),
    },
    "drake": {
        "armature": "joint 0 of body 1: nothing for 0.2",
        "stiffness": "",
        "gear": "actuator 0: 1 for 5",
        "kv": "actuator 1: 0 for 4",
    },
    "newton": {},
    "pinocchio": {  # the first tree alone is read
        "mass": "body 3: nothing for 3",
        "inertia": "body 3: nothing for 0.31 0.32 0.33",
        "damping": "slide: nothing for 0.7",
        **dict.fromkeys(("stiffness", "friction", "gear", "kp", "kv"), ""),
    },
    "pybullet": {
        "inertia": "body 1: 0 0 0 for 0.11 0.12 0.13",
        "armature": "",
        "damping": "joint 0 of body 1: 0 for 0.5",
        **dict.fromkeys(("stiffness", "gear", "kp", "kv"), ""),
    },
}


@pytest.mark.long
def test_what_has_no_name_is_named_by_its_place(tmp_path, capsys):
    (file := tmp_path / "unnamed.xml").write_text(UNNAMED, "utf-8")
    assert main(["models", "check", str(file), "--json"]) == 0
    readers = {reader["engine"]: reader for reader in json.loads(capsys.readouterr().out)}
    assert set(TAKEN) < set(readers.pop("mujoco")["read"])
    for engine, reader in readers.items():
        dropped = {f: why for f, why in reader["dropped"].items() if f in TAKEN}
        assert dropped == OF_UNNAMED[engine], engine


def test_elements_of_other_names_are_known_by_their_numbers():
    """In another order, and beside one that is missing; what has no number in common is taken in
    order, if as many are left."""
    wanted = {("damping", f"joint 0 of body {i}"): (0.1 * i,) for i in (1, 2, 3)}
    names = {"b": 0.2, "a": 0.1}
    given = {("damping", name): (value,) for name, value in names.items()}
    assert dropped(wanted, given) == {"damping": "joint 0 of body 3: nothing for 0.3"}
    given["damping", "c"] = (0.5,)
    assert dropped(wanted, given) == {"damping": "joint 0 of body 3: 0.5 for 0.3"}
    named = {("damping", f"hinge {i}"): (0.1 * i,) for i in (1, 2, 3)}
    assert dropped(named, given) == {"damping": "hinge 1: nothing for 0.1"}
