"""Benchmarks are kept, and `plumbob compare` tells which ratios moved beyond their quartiles."""

import json
from dataclasses import replace

import pytest

from plumbob.engines.study.provenance import Provenance
from plumbob.reports.cli import main
from plumbob.reports.judge import benchmarks
from plumbob.reports.judge.benchmarks import BenchmarkRun, Ratio, stored
from plumbob.tests.support.benchmark_runs import add

MADE = Provenance(
    {"mujoco": "3.17.0"}, {"processor": "a"}, "2026-01-01 00:00 UTC", "make benchmark"
)
LOOP = Ratio("adapter over bare loop", 0.97, 1.0, 1.03, most=1.1)
PEER = Ratio("DOP853 over closed form", 190.0, 200.0, 210.0, least=100.0)


@pytest.fixture
def history(tmp_path):
    """Three runs: the second is slower in both ratios, the third as the first, with another."""
    file = tmp_path / "kept" / "history.jsonl"
    slow = (
        replace(LOOP, low=1.45, median=1.5, high=1.55),
        replace(PEER, low=95.0, median=100.0, high=105.0),
    )
    for found in ((LOOP, PEER), slow, (LOOP, replace(PEER, low=150.0, name="another"))):
        add(BenchmarkRun(MADE, found), file)
    return file


def test_what_is_added_is_read_again(history):
    runs = stored(history)
    assert len(runs) == 3
    assert runs[0] == BenchmarkRun(MADE, (LOOP, PEER))
    assert benchmarks.keeps_benchmarks(history)


@pytest.mark.parametrize(
    ("old", "new", "said", "code"),
    [
        ("#1", "#2", ["bare loop: 1 -> 1.5 (50 % slower)", "form: 200 -> 100 (1e+02 % slower)"], 1),
        ("#2", "#1", ["bare loop: 1.5 -> 1 (50 % faster)", "form: 100 -> 200 (1e+02 % faster)"], 0),
        ("#1", "", ["DOP853 over closed form: measured -> no", "another: no -> measured"], 0),
        ("#1", "#1", ["nothing has moved"], 0),
    ],
)
def test_compare_tells_what_moved(old, new, said, code, history, capsys):
    words = ["compare", f"{history}{old}", f"{history}{new}"]
    assert main(words) == 0
    out = capsys.readouterr().out
    assert all(one in out for one in said), out
    assert out.count(" -> ") == len([one for one in said if "->" in one])
    assert main([*words, "--fail-above", "40%"]) == code
    capsys.readouterr()
    assert main([*words, "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)) == len([one for one in said if "->" in one])


def test_quartiles_that_overlap_have_not_moved(tmp_path):
    first = BenchmarkRun(MADE, (LOOP,))
    wide = replace(LOOP, low=1.02, median=1.5, high=1.9)
    near = replace(LOOP, low=1.1, median=1.2, high=1.3)
    for other in (wide, near):
        assert benchmarks.moved(first, BenchmarkRun(MADE, (other,)), 1.25) == ()
    apart = replace(LOOP, low=1.1, median=1.3, high=1.4)
    assert benchmarks.moved(first, BenchmarkRun(MADE, (apart,)), 1.25) == ((LOOP, apart),)
