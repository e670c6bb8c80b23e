"""The commands `sweep` and `worst`: what they print and write, and what they refuse."""

import json
from pathlib import Path

import numpy as np
import pytest

from plumbob.engines.box import Side, box
from plumbob.engines.registry import method
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.sweep.sweep import Swept, sweep_of
from plumbob.reports.cli import main
from plumbob.reports.view.sweep.page import MAX_MAP_CELLS, render, sweep_figures
from plumbob.reports.view.sweep.text import tenth_text, terminal_values
from plumbob.reports.view.tables import terminal_lines
from plumbob.tests.support.page_document import plotted_inside

SWEEP = ["sweep", "capsule-line", "mujoco/euler", "mujoco/euler+coulomb", "--jobs", "1"]
VARY = ["--vary", "heading=0:1.5:3", "--vary", "friction=0.3:0.6:2:log"]


def test_a_sweep_is_printed_written_and_kept(tmp_path, capsys):
    terminal_values = [*SWEEP, *VARY, "--out", str(tmp_path)]
    assert main([*terminal_values, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [row["method"] for row in answer["rows"]] == ["mujoco/euler", "mujoco/euler+coulomb"]
    assert answer["rows"][0]["largest"] > 0.1 > 1e-3 > answer["rows"][1]["largest"]
    page = Path(answer["page"]).read_text("utf-8")
    assert plotted_inside(page)[0]["data"][0]["type"] == "heatmap"
    assert answer["rows"][0]["worst"][0]["command"] in page
    assert main(terminal_values) == 0
    assert "6 of 6 points were stored" in capsys.readouterr().out


@pytest.mark.long
def test_the_command_of_a_worst_point_gives_its_error(tmp_path, capsys):
    terminal_values = [
        "worst",
        "capsule-line",
        "mujoco/euler+coulomb",
        "--within",
        "friction=0.3:0.4",
    ]
    assert main([*terminal_values, "--budget", "5", "--out", str(tmp_path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["certain"]
    main([*found["command"].split()[1:], "--json"])
    again = json.loads(capsys.readouterr().out)
    assert again["relative_error"] == found["error"]


def drawn(counts):
    """A sweep of so many points whose errors are made up, one of them much the largest."""
    names = ("heading", "friction", "gravity")[: len(counts)]
    around = box("capsule-line", {}, [Side(name, 0.3, 0.6) for name in names])
    asked = sweep_of(around, counts, [method("mujoco/euler")], [1e-3])
    errors = np.random.default_rng(7).uniform(1e-6, 1e-3, (1, 1, *counts))
    errors[0, 0].flat[asked.points // 3] = 0.5
    return Swept(asked, errors, {})


@pytest.mark.parametrize("counts", [(7,), (1000, 100), (5, 4, 3)])
def test_a_map_shows_the_largest_error_and_stays_small(counts):
    found = drawn(counts)
    page = render(found, Provenance())
    assert len(page.encode()) < 6e6
    assert "-0.301" in page or "0.5" in page  # its logarithm on a map, itself on a curve
    for figure in sweep_figures(found):
        for trace in figure.traces:
            key, largest = ("z", np.log10(0.5)) if "z" in trace else ("y", 0.5)
            assert np.array(trace[key], float).max() == pytest.approx(largest, rel=1e-3)
    assert "worst 50 %" in "\n".join(
        terminal_lines("sweep", **terminal_values(found), stored=0, page="")
    )
    assert MAX_MAP_CELLS < 1000


@pytest.mark.parametrize(
    ("points", "without", "ninety", "text"),
    [(10, 0, 0.01, "1 %"), (9, 0, 0.01, ""), (12, 3, 0.01, ""), (100, 0, 0.02, "")],
)
def test_nine_of_ten_are_said_of_ten_runs_or_more(points, without, ninety, text):
    """They are said only if they differ from the largest error, too."""
    row = {"ninety": ninety, "largest": 0.02, "without": without}
    assert tenth_text(row, points) == text
