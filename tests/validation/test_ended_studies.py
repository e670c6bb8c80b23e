"""A study that is ended at random moments (`--profile full`): nothing is lost or done twice."""

from __future__ import annotations

import os
import random
import signal
import time
from collections import Counter

import pytest

from plumbob.engines.study import runner
from plumbob.engines.study.store import FILE
from plumbob.reports.cli import main
from plumbob.tests.study import disturbed

MOMENTS = 20
LATEST = 3.0  # [s] of the study, after the first piece is there or the processes have loaded


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A folder with the study as it is when nothing ends it."""
    out = tmp_path_factory.mktemp("undisturbed")
    assert disturbed.run_to_its_end(out, 2) == (0, "")
    return out


def pytest_generate_tests(metafunc):
    """All ways to end a study at all moments, in the full profile; one job has no worker."""
    ways = [
        (number, jobs, target, moment)
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
        for jobs in (1, 2)
        for target in ("parent", "worker", "group")
        for moment in range(MOMENTS)
        if (target, jobs) != ("worker", 1)
    ]
    full = metafunc.config.getoption("--profile") == "full"
    if "moment" in metafunc.fixturenames:
        metafunc.parametrize(("number", "jobs", "target", "moment"), ways if full else [])
    else:
        metafunc.parametrize("jobs", [2] if full else [])


def test_a_worker_without_memory_costs_its_piece(jobs, tmp_path, undisturbed, monkeypatch, capsys):
    with monkeypatch.context() as patched:
        patched.setattr(runner, "_pair", disturbed.starved)
        assert main(disturbed.words(tmp_path, jobs)) == 3
    label = f"{disturbed.SCENE} {disturbed.STARVED}"
    assert f"given up: {label}: out of memory, 2 times" in capsys.readouterr().err
    assert main(disturbed.words(tmp_path, jobs)) == 0
    assert disturbed.figures(tmp_path) == disturbed.figures(undisturbed)


def test_a_study_goes_on(number, jobs, target, moment, tmp_path, undisturbed, request):
    chance = random.Random(request.node.name)
    (tmp_path / "index.html").write_text("old")
    study = disturbed.begun(tmp_path, jobs)
    pieces = chance.randrange(7)
    disturbed.until(lambda: len(disturbed.logged(tmp_path)) >= pieces, study)
    time.sleep(chance.uniform(0.0, LATEST) if pieces == 0 else chance.uniform(0.0, 0.1))
    if study.poll() is None:
        disturbed.sent(study, number, target)
    err, seconds = disturbed.ended(study)
    whole = disturbed.is_whole(tmp_path)
    if study.returncode != 0:
        assert study.returncode in (130, -number)  # -number: while Python loads
        assert seconds < disturbed.LOADED * disturbed.ENDS
        assert study.returncode != 130 or "Traceback" not in err
        # What was ended while it drew its pages is a whole study: `report` draws them.
        if whole:
            assert main(["report", str(tmp_path)]) == 0
        else:
            code, said = disturbed.run_to_its_end(tmp_path, jobs)
            assert code == 0, said
    assert (tmp_path / "index.html").read_text("utf-8") != "old"
    assert disturbed.group(study.pid) == []
    # A piece may be kept, and its process end before the list has it; none is there twice.
    assert set(Counter(disturbed.logged(tmp_path)).values()) == {1}
    assert disturbed.figures(tmp_path) == disturbed.figures(undisturbed)
    hidden = {name for name in os.listdir(tmp_path) if name.startswith((".studies", "studies."))}
    # A study that is killed between its end and its pages leaves its lock to the next one.
    assert hidden - ({f".{FILE}.lock"} if whole and number == signal.SIGKILL else set()) == {FILE}
