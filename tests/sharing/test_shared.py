"""Processes of one run share what is expensive, and each is given what the first has made."""

from __future__ import annotations

import threading

import pytest

from plumbob.models.registry import find_system
from plumbob.tests.sharing.shared import FOLDER, share, shared


def test_it_is_made_once(tmp_path, monkeypatch):
    """Also for who asks while it is being made; systems stay what they are."""
    monkeypatch.setenv(FOLDER, "")
    share(tmp_path / "run")
    made, found = [], []

    def make():
        made.append(threading.get_ident())
        return (find_system("cone-pendulum"), {"angle": 1.0})

    asking = [threading.Thread(target=lambda: found.append(shared("it", make))) for _ in "abc"]
    for one in asking:
        one.start()
    for one in asking:
        one.join()
    assert len(made) == 1
    assert [one[0] is find_system("cone-pendulum") for one in found] == [True] * 3
    assert [one[1] for one in found] == [{"angle": 1.0}] * 3


def test_what_fails_is_tried_again(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER, "")
    share(tmp_path)
    with pytest.raises(ZeroDivisionError):
        shared("it", lambda: 1 / 0)
    assert shared("it", lambda: 2.0) == 2.0
    assert shared("it", lambda: 3.0) == 2.0


def test_a_process_that_is_begun_by_a_test_makes_its_own(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER, f"1:{tmp_path}")
    assert [shared("it", lambda n=n: n) for n in (1, 2)] == [1, 2]
