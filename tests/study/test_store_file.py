"""A file that is no store of ours, or cannot be used now: one line, and no byte of it changed."""

import os
import sqlite3
from contextlib import closing, contextmanager

import pytest

from plumbob.engines.registry import method
from plumbob.engines.study import store, store_file
from plumbob.reports.cli import main
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import SCENE, made_up

WRITERS = (("validate", "--scenes", SCENE, "--methods", "ode/rk4", "--jobs", "1", "--out"),)
READERS = (
    ("report",),
    ("compare", "STORE"),
    ("recommend", SCENE, "--error", "1e-3", "--stored", "--out"),
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The bytes of a small store."""
    file = tmp_path_factory.mktemp("whole") / store.FILE
    save(made_up([(method("ode/rk4"), (1e-2, 1e-3), lambda step: step**4)]), file)
    return file.read_bytes()


def _with(statement):
    def made(file, whole):
        file.write_bytes(whole)
        with closing(sqlite3.connect(file)) as opened, opened:
            opened.executescript(statement)

    return made


def _foreign(file, whole):
    with closing(sqlite3.connect(file)) as opened, opened:
        opened.execute("create table result (id integer)")


def _torn(file, whole):
    file.write_bytes(whole[: len(whole) // 2])


BAD = {
    "text": (lambda file, whole: file.write_text("what is this" * 200), "not a database"),
    "foreign": (_foreign, "it holds other data"),
    "truncated": (_torn, "must be a"),
    "older": (_with("pragma user_version = 3"), "an older one"),
    "newer": (_with("pragma user_version = 99"), "a newer one"),
    "trigger": (
        _with("create trigger t after insert on result begin delete from result; end"),
        "it holds other data",
    ),
    "view": (
        _with("drop table result; create view result as select 1 as study"),
        "it holds other data",
    ),
    "other table": (_with("create table own (x)"), "it holds other data"),
    "other columns": (
        _with("drop table result; create table result (study, body)"),
        "it holds other data",
    ),
    "no table": (_with("drop table result"), "it holds other data"),
    "pipe": (lambda file, whole: os.mkfifo(file), "a regular file"),
    "folder": (lambda file, whole: file.mkdir(), "must be"),
}


@pytest.mark.parametrize("kind", BAD)
@pytest.mark.parametrize("words", [*WRITERS, *READERS], ids=lambda words: str(words[0]))
def test_what_is_no_store_is_one_line_and_stays_as_it_is(kind, words, whole, tmp_path, capsys):
    file = tmp_path / store.FILE
    make, said = BAD[kind]
    make(file, whole)
    before = file.read_bytes() if file.is_file() else None
    _refused(words, file, said, capsys)
    assert before is None or file.read_bytes() == before
    assert list(tmp_path.iterdir()) == [file]


def _refused(words, file, said, capsys):
    given = [str(file) if word == "STORE" else word for word in words]
    assert main([*given, str(file.parent)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert said in captured.err


@contextmanager
def _locked(file):
    with closing(sqlite3.connect(file, isolation_level=None)) as other:
        other.execute("begin exclusive")
        yield
        other.execute("rollback")


@pytest.mark.parametrize("words", [*WRITERS, *READERS], ids=lambda words: str(words[0]))
def test_a_locked_store_is_said_to_be_locked(words, whole, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(store_file, "LOCK_WAIT", 0.01)
    file = tmp_path / store.FILE
    file.write_bytes(whole)
    with _locked(file):
        _refused(words, file, "no other process has locked", capsys)
    assert file.read_bytes() == whole
