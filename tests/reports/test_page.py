"""The page is self-contained, is written completely or not at all, and shows what was measured."""

from __future__ import annotations

import html
import json
import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbob.analytic.errors.schemes import RK4, Scheme
from plumbob.engines.method import Method
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.study.results import Study
from plumbob.reports.advice.work_precision import Point, front
from plumbob.reports.cli import main
from plumbob.reports.findings import section
from plumbob.reports.view.content import Finding, Section
from plumbob.reports.view.page import figure_json, write_page
from plumbob.reports.view.palette import styles
from plumbob.reports.view.traces import MOST, curve, figure, linear, logarithmic
from plumbob.tests.support import browser
from plumbob.tests.support.page_document import Document, resolve, words
from plumbob.tests.support.studies import made_up, quick

MEGABYTES = 8.0
HOSTILE = "<script>alert('x')</script><img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_page(quick(), tmp_path_factory.mktemp("page") / "new", section)


@pytest.fixture(scope="module")
def document(page: Path) -> Document:
    return Document(page.read_text("utf-8"))


def test_one_small_file(page: Path) -> None:
    assert [path.name for path in page.parent.iterdir()] == ["index.html"]
    assert page.stat().st_size < MEGABYTES * 1e6


def test_it_loads_nothing(document: Document) -> None:
    assert document.loaded == []
    assert all(link.startswith("#") for link in document.links)


def test_every_link_leads_somewhere(document: Document) -> None:
    assert len(document.ids) == len(set(document.ids))
    assert {link[1:] for link in document.links} <= set(document.ids)


def test_plotly_is_included_once(document: Document) -> None:
    assert sum(len(script) > 1_000_000 for script in document.scripts) == 1


def test_every_scene_method_and_number_is_in_a_table(document: Document) -> None:
    study, said = quick(), " ".join(document.cells)
    for scene in study.scenes:
        assert scene.name in said
    for method in study.methods:
        assert method.name in said
    for name in ("pass", "19.655093168750", "13.389704809267", "19.729447983"):
        assert name in said


def test_foot_says_where_it_comes_from(page: Path) -> None:
    foot = page.read_text("utf-8").partition('id="provenance"')[2].partition("</footer>")[0]
    for word in ("plumbob validate", "cone-*", "mujoco", "numpy", "UTC", "cores"):
        assert word in foot


def test_commands_on_the_page_run(page: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each can be read, and what it names is there; the shortest of each cheap kind runs."""
    shown = re.findall(r"<code>(plumbob .*?)</code>", page.read_text("utf-8"))
    kinds: dict[str, list[str]] = {}
    for command in map(html.unescape, shown):
        resolve(command, page.parent)
        kinds.setdefault(words(command)[0], []).append(command)
    assert set(kinds) == {"validate", "solve", "run", "settings"}
    for kind in ("solve", "run", "settings"):
        assert main(words(min(kinds[kind], key=len))) == 0
        assert capsys.readouterr().err == ""


def test_plots_are_light(document: Document) -> None:
    assert len(document.figures) >= 5 * len(quick().scenes)
    for found in document.figures:
        for trace in found["data"]:
            assert 0 < len(trace["x"]) <= MOST
            if trace["type"] == "heatmap":
                assert {len(line) for line in trace["z"]} == {len(trace["x"])}
                assert len(trace["z"]) == len(trace["y"]) <= MOST // 5
            else:
                assert len(trace["x"]) == len(trace["y"])


def test_work_precision_hints_state_method_step_error_cost(document: Document) -> None:
    plots = [f for f in document.figures if "wall time" in f["layout"]["xaxis"]["title"]["text"]]
    assert len(plots) == len(quick().scenes)
    for trace in plots[0]["data"]:
        for text in trace.get("text", ()):
            assert re.fullmatch(r"(rtol )?[\d.e-]+( s)?, real-time factor .*", text)
        if "text" in trace:
            for word in (trace["name"], "%{text}", "error %{y", "rad", "cost %{x"):
                assert word in trace["hovertemplate"]


def test_axes_have_units(document: Document) -> None:
    for found in document.figures:
        for name, axis in found["layout"].items():
            if re.fullmatch(r"[xy]axis\d*", name):
                title = axis["title"]["text"]
                assert "[" in title or " / " in title, title


def test_markup_from_outside_is_escaped(tmp_path: Path) -> None:
    study = made_up([(Method("made/up", Scheme(RK4), 4), (1e-3, 1e-4), lambda h: h)])
    scene = replace(study.scenes[0], summary=HOSTILE)
    convergence_study = study.convergence[0]
    runs = tuple(
        replace(m, status="diverged", reason=HOSTILE) for m in convergence_study.measurements
    )
    hostile = replace(
        study,
        scenes=(scene,),
        convergence=(replace(convergence_study, measurements=runs),),
        costs={},
        provenance=Provenance(command=HOSTILE),
    )
    text = write_page(hostile, tmp_path, section=lambda name: None).read_text("utf-8")
    assert "onerror" in text
    assert "img" not in Document(text).tags
    assert HOSTILE not in text


def test_figure_json_is_no_markup() -> None:
    plot = figure("t", "c", [curve([1.0], [2.0], name="</script>")], linear("x"), linear("y"))
    assert "<" not in figure_json(plot)
    assert json.loads(figure_json(plot))["data"][0]["name"] == "</script>"


def test_nothing_is_half_written(tmp_path: Path) -> None:
    def breaks(study: Study) -> Sequence[Finding]:
        raise RuntimeError("broken finding")

    old = tmp_path / "index.html"
    old.write_text("old", "utf-8")
    broken = Section(breaks, lambda study: (), lambda study, scene: ())
    with pytest.raises(RuntimeError, match="broken finding"):
        write_page(quick(), tmp_path, section=lambda name: broken)
    assert [path.read_text("utf-8") for path in tmp_path.iterdir()] == ["old"]


def test_a_file_in_the_way_is_left_alone(tmp_path: Path) -> None:
    study = made_up([(Method("made/up", Scheme(RK4), 4), (1e-3,), lambda h: h)])
    (tmp_path / "out").write_text("other", "utf-8")
    with pytest.raises(OSError, match="out"):
        write_page(study, tmp_path / "out", section=lambda name: None)
    assert (tmp_path / "out").read_text("utf-8") == "other"


def test_a_system_without_a_section_has_none() -> None:
    assert section("no-such-system") is None
    assert section("cone-pendulum") is not None


def test_methods_keep_their_colours() -> None:
    methods = quick().methods
    whole, part = styles(methods), styles(methods[1:])
    assert all(whole[m.name].colour == part[m.name].colour for m in methods[1:])
    assert len({(s.colour, s.marker) for s in whole.values()}) == len(methods)


def test_front_has_no_dominated_point() -> None:
    costs, errors = (1.0, 2.0, 2.0, 3.0, 4.0), (1.0, 0.5, 0.7, 0.6, 0.1)
    points = [Point("m", 1.0, e, c) for c, e in zip(costs, errors, strict=True)]
    kept = front(points, lambda p: (p.ns_per_second, p.error))
    assert [(p.ns_per_second, p.error) for p in kept] == [(1, 1), (2, 0.5), (4, 0.1)]


def test_a_curve_is_thinned_and_its_gaps_remain() -> None:
    y = np.ones(10_000)
    y[0] = math.nan
    drawn = curve(np.arange(10_000.0), y)
    assert len(drawn["x"]) == MOST
    assert drawn["y"][0] is None
    axis = figure("t", "c", [curve([1, 1e9], [1, 1e9])], logarithmic("x"), linear("y")).layout
    assert axis["xaxis"]["dtick"] == 2


def test_in_a_browser(page: Path, tmp_path: Path, document: Document) -> None:
    seen = browser.look(page, "#all", tmp_path)
    assert seen.console == ()
    assert seen.document.count('class="plot-container') == len(document.figures)
    drawn = re.findall(r'<path class="js-line"[^>]* d="M', seen.document)
    assert len(drawn) > 2 * len(document.figures)
    rows = browser.screenshot(page, tmp_path / "page.png", tmp_path)
    assert len(set(rows)) > len(rows) // 3  # text and tables; a blank page has one or two


@pytest.mark.parametrize(
    ("place", "change", "complaint"),
    [
        ("<h1>", '<img src="https://example.org/x.png"><h1>', "example.org"),
        ("Plotly.newPlot(area", "Plotly.noPlot(area", "noPlot"),
    ],
)
def test_the_browser_reports_a_broken_page(
    place: str, change: str, complaint: str, tmp_path: Path
) -> None:
    study = made_up([(Method("made/up", Scheme(RK4), 4), (1e-3, 1e-4), lambda h: h)])
    page = write_page(study, tmp_path / "out", section=lambda name: None)
    text = page.read_text("utf-8")
    assert text.count(place) == 1
    page.write_text(text.replace(place, change), "utf-8")
    seen = browser.look(page, "#all", tmp_path)
    assert any(complaint in line for line in seen.console)
