"""`plumbob stability --json` ends in an answer on every scene of the profile."""

import json
import math

import pytest

from plumbob.engines.study import stability
from plumbob.models.registry import matching_scenes
from plumbob.reports.cli import main


def pytest_generate_tests(metafunc):
    """Every scene of the profile that is asked for. Of the quick profile the first scene of each
    system stands for its others, which only `make test-long` runs."""
    option = metafunc.config.getoption
    chosen = matching_scenes(option("scenes"), option("profile"))
    first = {scene.system: scene for scene in reversed(chosen)}.values()
    enough = first if option("profile") == "quick" else chosen
    marks = [() if scene in enough else pytest.mark.rare for scene in chosen]
    cases = [pytest.param(scene, marks=of) for scene, of in zip(chosen, marks, strict=True)]
    metafunc.parametrize("scene", cases, ids=[scene.name for scene in chosen])


@pytest.mark.long
def test_every_scene_ends_in_an_answer(scene, capsys, monkeypatch):
    """Of runs of a fifth of the usual steps, but where they take most of these to be lost."""
    if scene.system not in ("free-body", "heavy-top"):
        monkeypatch.setattr(stability, "MIN_RUN_STEPS", stability.MIN_RUN_STEPS // 5)
    assert main(["stability", scene.name, "mujoco/euler", "--json", "--jobs", "1"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert records
    for record in records:
        assert (record["scene"], record["method"]) == (scene.name, "mujoco/euler")
        holds = record["holds"]
        fails = record["fails"]
        assert record["why"]
        if record["kind"] is not None:
            assert (holds or 0.0) < (math.inf if fails is None else fails)
