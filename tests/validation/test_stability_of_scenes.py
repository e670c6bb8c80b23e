"""`plumbob stability --json` ends in an answer on every scene of the profile."""

import json
import math

import pytest

from plumbob.engines.study import stability
from plumbob.models.registry import matching_scenes
from plumbob.reports.cli import main


def pytest_generate_tests(metafunc):
    """Every system that has scenes in the profile that is asked for."""
    option = metafunc.config.getoption
    chosen = matching_scenes(option("scenes"), option("profile"))
    metafunc.parametrize("system", list(dict.fromkeys(scene.system for scene in chosen)))


@pytest.mark.long
def test_every_scene_ends_in_an_answer(system, capsys, monkeypatch, pytestconfig):
    """Of runs of a fifth of the usual steps, but where they take most of these to be lost."""
    option = pytestconfig.getoption
    if system not in ("free-body", "heavy-top"):
        monkeypatch.setattr(stability, "MIN_RUN_STEPS", stability.MIN_RUN_STEPS // 5)
    chosen = matching_scenes(option("scenes"), option("profile"))
    for name in (scene.name for scene in chosen if scene.system == system):
        assert main(["stability", name, "mujoco/euler", "--json", "--jobs", "1"]) == 0
        records = json.loads(capsys.readouterr().out)
        assert records
        for record in records:
            assert (record["scene"], record["method"]) == (name, "mujoco/euler")
            holds = record["holds"]
            fails = record["fails"]
            assert record["why"]
            if record["kind"] is not None:
                assert (holds or 0.0) < (math.inf if fails is None else fails)
