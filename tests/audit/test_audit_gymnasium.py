"""An environment of Gymnasium, audited from its reset on: its own rollout, to the bit."""

import importlib
import json
import warnings
from pathlib import Path

import numpy as np
import pytest

from plumbob import audit
from plumbob.engines.audit.environments import environment
from plumbob.reports.cli import main
from plumbob.tests.support.first_verdicts import without_first_verdict

POLE = "InvertedPendulum-v5"
QUICK = ["--duration", "0.2", "--budget", "5"]


def steering(observation):
    return np.clip([2.0 * observation[1] + 0.5 * observation[0] + 0.1], -3.0, 3.0)


for package in ("gymnasium", "imageio"):
    pytest.importorskip(package)


@pytest.mark.long
def test_the_rollout_is_gymnasiums_own_to_the_bit():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = importlib.import_module("gymnasium").make(POLE)
        observation, _ = theirs.reset(seed=3)
        states = []
        controls = []
        for _ in range(5):
            states.append(theirs.unwrapped.state_vector())
            observation, *_ = theirs.step(steering(observation))
            controls.append(theirs.unwrapped.data.ctrl.copy())
        states.append(theirs.unwrapped.state_vector())
    found = audit(environment(POLE, seed=3), policy=steering, duration=0.2, budget=5.0)
    assert found.script.period == pytest.approx(theirs.unwrapped.dt)
    np.testing.assert_array_equal(found.script.controls, controls)
    parts = round(found.script.period / found.step)
    ours = found.model.stepped(found.script, found.integrator, parts).states
    np.testing.assert_array_equal(ours, states)
    assert found.complete
    assert np.ptp(controls) > 0.01  # it steers


@pytest.mark.long
def test_on_the_command_line(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("own_pole.py").write_text("def act(observation):\n    return 0.1 * observation[:1]\n")
    words = ["audit", "--gym", POLE, *QUICK, "--seed", "3"]
    assert main([*words, "--policy", "own_pole:act", "--json", "--out", "pages"]) == 0
    printed = capsys.readouterr()
    data = json.loads(printed.out)
    assert (data["model"], data["control"][:6]) == (POLE, "policy")
    page = Path(without_first_verdict(printed.err).strip()).read_text("utf-8")
    assert f"plumbob audit --gym {POLE} " in page
    assert main(["audit", "--gym", POLE, *QUICK]) == 0
    assert f"{POLE}" in capsys.readouterr().out
    for wrong in (
        ["--gym", "CartPole-v1"],
        ["--gym", "NoSuchPole-v0"],
        ["--gym", POLE, "--seed", "-1"],
        ["--gym", POLE, "--keyframe", "0"],
        ["--gym", POLE, "--policy", "json:loads"],
        ["my.xml", "--gym", POLE],
    ):
        assert main(["audit", *wrong]) == 2
        assert capsys.readouterr().err.count("\n") == 1
