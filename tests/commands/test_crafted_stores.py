"""Stores that somebody else has written, with right checksums: one line, and nothing is changed."""

import json
import shutil
import sqlite3
import tempfile
from contextlib import closing
from types import MappingProxyType

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import measured_into
from plumbob.engines.study.codec import to_json
from plumbob.engines.study.convergence import ConvergenceStudy
from plumbob.engines.study.results import Analysed, TaskResult
from plumbob.engines.study.runner import convergence_task
from plumbob.engines.study.scheduler import worked_out
from plumbob.models.registry import scene as find_scene
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


def _changed(path, value, added=False):
    def make(body):
        held = at = json.loads(body)
        for name in path[:-1]:
            at = at[name]
        at[path[-1]] = at[path[-1]] + value if added else value
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


def _analysis(numbers):
    """Adds to the study an analysis of engines with numbers of somebody's own."""

    def change(opened):
        held = Analysed("engines/largest_steps", "finding", "engines", "", numbers)
        body = to_json(TaskResult(held))
        key = f"{store.ANALYSIS}99"
        (number,) = opened.execute("select max(study) from result").fetchone()
        row = number, key, body
        opened.execute("insert into result values (?, ?, ?, ?)", (*row, store._digest(*row)))
        _rewritten(opened, store.STUDY, _changed(("results",), [[key, ""]], added=True))

    return change


def _misplaced(opened, of='%"TrimmingRun"%', to='%"StabilitySearch"%'):
    """A result stands under the key of another request, whose own result is lost."""
    (body,) = opened.execute("select body from result where body like ?", (to,)).fetchone()
    _rewritten(opened, of, lambda _: body)


def _left_out(opened):
    """The list leaves out a pair that the pages' numbers have a verdict of."""
    query = "select key from result where body like '%\"ConvergenceStudy\"%'"
    (key,) = opened.execute(query).fetchone()
    _rewritten(opened, store.STUDY, _without(key))


def _without(key):
    def make(body):
        held = json.loads(body)
        return json.dumps({**held, "results": [of for of in held["results"] if of[0] != key]})

    return make


FORGED = MappingProxyType(
    {
        "numbers of another type": _analysis({"limits": 3.0, "paid": {}}),
        "numbers of other names": _analysis({"limits": [], "paid": {"a": None}}),
        "a result of another request": _misplaced,
        "an answer of another kind": lambda opened: _rewritten(
            opened, '%"TrimmingRun"%', _changed(("kinds", "request"), "ExtraRun")
        ),
        "a pair left out": _left_out,
        "a parameter that is no number": lambda opened: _rewritten(
            opened,
            store.STUDY,
            _changed(("study", "scenes", 0, "parameters", "gravity"), float("nan")),
        ),
        "a name that is no text": lambda opened: _rewritten(
            opened, '%"TrimmingRun"%', _changed(("request", "scene"), [1])
        ),
    }
)


@pytest.mark.parametrize("kind", FORGED)
def test_what_does_not_follow_from_the_runs_is_refused(kind, stored, monkeypatch, capsys):
    """No type tells that a template cannot show a number."""
    _crafted(stored, FORGED[kind])
    monkeypatch.chdir(stored)
    before = {p: p.stat().st_mtime_ns for p in stored.rglob("*")}
    code = main(("report", "made"))
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1), err
    assert {p: p.stat().st_mtime_ns for p in stored.rglob("*")} == before


def test_a_template_that_fails_on_the_right_numbers_is_a_defect(
    stored, monkeypatch, capsys, tmp_path
):
    def planted(*_):
        raise TypeError("planted")

    monkeypatch.chdir(stored)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr("plumbob.reports.view.site.views.findings_about", planted)
    assert main(("report", "stored")) == 4
    assert "a defect of plumbob itself" in capsys.readouterr().err


def test_a_kept_result_of_another_pair_is_not_taken():
    """It is measured again."""
    scene = find_scene(SCENE)
    wanted = convergence_task(scene, find_method("ode/euler"), "quick", 1)
    with measured_into(None) as kept:
        kept.begin("plan", [wanted.key])
        kept.keep({wanted.key: TaskResult(ConvergenceStudy(SCENE, "ode/rk4", ()))})
        (found,) = worked_out([wanted], kept, None, lambda *_: None).values()
        assert (found.answer.method, found.answer.measurements != ()) == ("ode/euler", True)
        assert kept.there([wanted.key]) == {wanted.key: found}


@pytest.mark.parametrize("text", [DEEP, "nan", "", "[]", "1" * 5000, '"\\ud800"'])
def test_texts_that_are_no_list_are_refused(text, stored, monkeypatch, capsys):
    _crafted(stored, lambda opened: _rewritten(opened, store.STUDY, lambda body: text))
    _refused(stored, monkeypatch, capsys)
