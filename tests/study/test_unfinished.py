"""Pieces of a study: known by what defines them, claimed by one process, kept when it ends."""

from __future__ import annotations

import os
import signal
import sqlite3
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import method, methods
from plumbob.engines.study import provenance, unfinished
from plumbob.engines.study.provenance import versions_of
from plumbob.engines.study.store import FILE
from plumbob.engines.study.unfinished import Piece, key_of, measured_into
from plumbob.models.registry import scene

SCENE = "linear-pendulum/overdamped"


def test_a_key_follows_from_all_that_defines_a_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    one, rk4 = scene(SCENE), method("ode/rk4")

    def key(**changed: object) -> str:
        given = {"scene": one, "method": rk4, "most": 1000, **changed}
        return key_of(*given.values(), versions_of(rk4))

    monkeypatch.setattr(provenance, "_version", partial(_changed, ""))
    same = key()
    assert key() == same
    (name, value), *_ = one.parameters.items()
    others = {
        "parameter": key(scene=replace(one, parameters={**one.parameters, name: 1.000001 * value})),
        "steps": key(scene=replace(one, steps=one.steps[1:])),
        "settings": key(method=replace(rk4, settings={"other": 1})),
        "most steps": key(most=1001),
    }
    for package in ("plumbob", "scipy", "numpy"):
        with monkeypatch.context() as patched:
            patched.setattr(provenance, "_version", partial(_changed, package))
            others[package] = key()
    monkeypatch.setattr(unfinished, "_source", lambda: "another file of plumbob")
    others["source"] = key()
    assert len({same, *others.values()}) == 1 + len(others)


def _changed(package: str, named: str) -> str:
    return "another" if named == package else "1.0"


OTHERS = ("mujoco", "mujoco"), ("pymunk", "pymunk"), ("pinocchio", "pin"), ("mjx", "jax")


@pytest.mark.parametrize(("engine", "package"), OTHERS)
def test_the_version_of_an_engine_is_known(
    engine: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(provenance, "_version", lambda named: f"version of {named}")
    assert versions_of(methods(engine)[0])[package] == f"version of {package}"


def _in_another_process(do: Callable[[], None]) -> int:
    """A process that does something, and then waits to be ended."""
    ours, theirs = os.pipe()
    child = os.fork()
    if not child:
        try:
            do()
        finally:
            os.write(theirs, b".")
            signal.pause()
            os._exit(0)
    os.read(ours, 1)
    os.close(ours)
    os.close(theirs)
    return child


def test_a_claim_ends_with_its_process(tmp_path: Path) -> None:
    held = ExitStack()

    def begin() -> None:
        kept = held.enter_context(measured_into(tmp_path / FILE))
        kept.begin("a plan", ["one", "two"])
        assert kept.claim("one", "the first") == "ours"
        kept.keep("one", Piece(seconds=3.0))
        kept.claim("two", "the second")

    child = _in_another_process(begin)
    notes: list[str] = []
    with measured_into(tmp_path / FILE, note=notes.append) as kept:
        kept.begin("a plan", ["one", "two"])
        assert notes == ["goes on: 1 of 2 pieces are there"]
        assert kept.there(["one", "two", "three"])["one"].seconds == 3.0
        assert kept.claim("one", "the first") == "there"
        assert kept.claim("two", "the second") == "theirs"
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        assert kept.claim("two", "the second") == "cut off"
        assert kept.claim("two", "the second") == "ours"
    assert not [file for file in tmp_path.iterdir() if "lock" in file.name]


def test_costs_are_measured_by_one_process_at_a_time(tmp_path: Path) -> None:
    held = ExitStack()

    def begin() -> None:
        kept = held.enter_context(measured_into(tmp_path / FILE))
        kept.begin("a plan", [])
        held.enter_context(kept.alone())

    child = _in_another_process(begin)
    ended: list[str] = []

    def end(said: str) -> None:
        ended.append(said)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)

    with measured_into(tmp_path / FILE, note=end) as kept, kept.alone():
        assert ended == ["waits for another process, which measures costs into the same folder"]


def test_a_piece_that_was_given_up_is_open_again(tmp_path: Path) -> None:
    with measured_into(tmp_path / FILE) as kept:
        kept.begin("a plan", ["one"])
        kept.claim("one", "the first")
        kept.keep("one", Piece(lost="no memory"))
        assert kept.there(["one"])["one"].lost == "no memory"
    with measured_into(tmp_path / FILE) as kept:
        kept.begin("a plan", ["one"])
        assert kept.there(["one"]) == {}
        assert kept.claim("one", "the first") == "ours"


@pytest.mark.parametrize("body", ["{", '{"convergence": 1}', "[]"])
def test_a_piece_that_cannot_be_read_back_is_one_line(body: str, tmp_path: Path) -> None:
    with measured_into(tmp_path / FILE) as kept:
        kept.begin("a plan", ["one"])
        kept.claim("one", "the first")
        kept.keep("one", Piece())
    with closing(sqlite3.connect(tmp_path / FILE)) as opened:
        opened.execute("update piece set body = ?", (body,))
        opened.commit()
    refused = pytest.raises(ParameterError, match=f"{FILE}': must be a file of stored studies")
    with refused, measured_into(tmp_path / FILE) as kept:
        kept.begin("a plan", ["one"])
        kept.there(["one"])


def test_a_fresh_study_leaves_what_is_there(tmp_path: Path) -> None:
    with measured_into(tmp_path / FILE) as kept:
        kept.begin("a plan", ["one"])
        kept.claim("one", "the first")
        kept.keep("one", Piece())
    for fresh, there in ((False, {"one"}), (True, set()), (False, set())):
        with measured_into(tmp_path / FILE, fresh) as kept:
            kept.begin("a plan", ["one"])
            assert set(kept.there(["one"])) == there
