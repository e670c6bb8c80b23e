"""Stores that somebody else has written, with right checksums: one line, and nothing is changed."""

import json
import shutil
import sqlite3
from contextlib import closing
from types import MappingProxyType

import pytest

from plumbob.engines.study import store
from plumbob.reports.cli import main

SCENE = "linear-pendulum/overdamped"
METHODS = "ode/dop853,mujoco/rk4"
COMMANDS = (
    ("report", "made"),
    ("compare", "made", "stored"),
    ("compare", "stored", "made"),
    ("recommend", SCENE, "--error", "0.01", "--stored", "--out", "made"),
)
TYPES = MappingProxyType(
    {
        "study, text": "update result set study = 'abc' || study",
        "study, huge": "update result set study = 9223372036854775807",
        "study, negative": "update result set study = -1",
        "body, bytes": "update result set body = x'00ff'",
        "body, number": "update result set body = 1e308",
        "digest, number": "update result set digest = 3",
        "key, bytes": "update or ignore result set key = x'00'",
        "a view": "create view v as select * from result",
        "another table": "drop table result",
        "schema": "pragma user_version = 2147483647",
    }
)
DEEP = "[" * 100_000
# Keys of the JSON of a study's list, and what stands in their place.
CHANGES = (
    (("study",), None),
    (("study",), "os.system"),
    (("results",), [["x", 3]]),
    (("results",), {"a": 1}),
    (("results", 0, 0), "nothing"),
    (("study", "scenes"), []),
    (("study", "scenes", 0, "name"), "nobody/none"),
    (("study", "scenes", 0, "duration"), 10**400),
    (("study", "scenes", 0, "parameters"), [[[]]]),
    (("study", "methods"), []),
    (("study", "methods", 0, "name"), "\0"),
    (("study", "observed"), {}),
    (("study", "observed", SCENE), []),
    (("study", "interest", SCENE, 0, "observable"), "\0"),
    (("study", "provenance"), 1),
    (("study", "profile"), "none"),
)
KINDS = (  # of a result
    (("kinds", "answer"), "os.system"),
    (("kinds",), {"answer": "Measurement"}),
    (("kinds",), {}),
    (("answer",), None),
    (("answer", "scene"), "nobody/none"),
    (("answer", "method"), "nobody"),
    (("answer", "measurements", 0, "errors"), {"nothing": None}),
)


@pytest.fixture(name="stored", scope="module")
def _stored(tmp_path_factory):
    """A folder with a small study."""
    made = tmp_path_factory.mktemp("crafted")
    wanted = ("--scenes", SCENE, "--methods", METHODS, "--jobs", "1")
    assert main(("validate", *wanted, "--out", str(made / "stored"))) == 0
    return made


def _crafted(folder, change):
    """A copy of the store, changed by a function of its connection."""
    shutil.rmtree(folder / "made", ignore_errors=True)
    shutil.copytree(folder / "stored", folder / "made")
    with closing(sqlite3.connect(folder / "made" / store.FILE)) as opened, opened:
        change(opened)


def _rewritten(opened, like, make):
    """The text of the first row whose key or text is `like` that is rewritten, its checksum right
    again."""
    query = "select study, key, body from result where key like ? or body like ?"
    number, key, body = opened.execute(query, (like, like)).fetchone()
    row = number, key, make(body)
    opened.execute("replace into result values (?, ?, ?, ?)", (*row, store._digest(*row)))


def _changed(path, value):
    def make(body):
        held = at = json.loads(body)
        for name in path[:-1]:
            at = at[name]
        at[path[-1]] = value
        return json.dumps(held)

    return make


def _refused(folder, monkeypatch, capsys, codes=(2,)):
    monkeypatch.chdir(folder)
    before = {p: p.stat().st_mtime_ns for p in folder.rglob("*")}
    for words in COMMANDS:
        code = main(words)
        out, err = capsys.readouterr()
        assert code in codes, (words, err)
        if code == 2:
            assert (out, err.count("\n")) == ("", 1), err
            assert {p: p.stat().st_mtime_ns for p in folder.rglob("*")} == before


@pytest.mark.parametrize("kind", TYPES)
def test_columns_of_other_types_are_refused(kind, stored, monkeypatch, capsys):
    _crafted(stored, lambda opened: opened.execute(TYPES[kind]))
    _refused(stored, monkeypatch, capsys, codes=(0, 1, 2))
    wanted = ("--scenes", SCENE, "--methods", METHODS, "--jobs", "1", "--out", "made")
    assert main(("validate", *wanted)) in (0, 2)


@pytest.mark.parametrize(("path", "value"), CHANGES)
def test_a_list_of_another_shape_is_refused(path, value, stored, monkeypatch, capsys):
    _crafted(stored, lambda opened: _rewritten(opened, store.STUDY, _changed(path, value)))
    _refused(stored, monkeypatch, capsys, codes=(0, 1, 2))


@pytest.mark.parametrize(("path", "value"), KINDS)
def test_a_result_of_another_kind_is_refused(path, value, stored, monkeypatch, capsys):
    _crafted(
        stored, lambda opened: _rewritten(opened, '%"ConvergenceStudy"%', _changed(path, value))
    )
    _refused(stored, monkeypatch, capsys, codes=(0, 1, 2))


@pytest.mark.parametrize("text", [DEEP, "nan", "", "[]", "1" * 5000, '"\\ud800"'])
def test_texts_that_are_no_list_are_refused(text, stored, monkeypatch, capsys):
    _crafted(stored, lambda opened: _rewritten(opened, store.STUDY, lambda body: text))
    _refused(stored, monkeypatch, capsys)
