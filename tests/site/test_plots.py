"""Every plot is a picture with its labels inside it and apart, and plotly's where pressed."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.registry import method
from plumbob.reports.advice.work_precision import Point
from plumbob.reports.view.drawing import drawing, shown
from plumbob.reports.view.page import Plots
from plumbob.reports.view.palette import styles
from plumbob.reports.view.plotly_figure import (
    FRONT,
    curve,
    figure,
    heat,
    linear,
    logarithmic,
)
from plumbob.reports.view.plots import error_against_cost
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import site_files

SCENE = "capsule-line-ca1.html"
# Of pictures, those of whose labels one is not inside, and those with two that overlap by more
# than the half pixel to which browsers round.
MISPLACED = """(pictures) => Object.entries(pictures).flatMap(([name, text]) => {
  const holder = document.body.appendChild(document.createElement("div"));
  holder.innerHTML = text;
  const svg = holder.firstElementChild, view = svg.viewBox.baseVal;
  svg.setAttribute("width", view.width);
  svg.setAttribute("height", view.height);
  const around = svg.getBoundingClientRect(), faults = [];
  const labels = [...svg.querySelectorAll("text")].filter((one) => one.textContent);
  const boxes = labels.map((one) => one.getBoundingClientRect());
  boxes.forEach((box, i) => {
    if (box.left < around.left - 1 || box.right > around.right + 1 || box.top < around.top - 3 ||
        box.bottom > around.bottom + 1) faults.push(`${name} outside: ${labels[i].textContent}`);
    boxes.slice(0, i).forEach((other, j) => {
      if (Math.min(box.right, other.right) - Math.max(box.left, other.left) > .5 &&
          Math.min(box.bottom, other.bottom) - Math.max(box.top, other.top) > 2.5)
        faults.push(`${name} overlap: ${labels[i].textContent} | ${labels[j].textContent}`);
    });
  });
  holder.remove();
  return faults;
})"""


def _pictures(index, whole):
    """The pictures of a site by file, or those of one page of each kind."""
    folder = site_files(index)[1].parent
    pages = "*.html" if whole else "cap*-line*1.html"
    pages_with = [page.read_text("utf-8") for page in sorted(folder.glob(pages))]
    names = {name for text in pages_with for name in re.findall(r'src="(\w{12}\.svg)"', text)}
    return {name: (folder / name).read_text("utf-8") for name in sorted(names)}


def test_every_label_is_inside_its_picture_and_apart(index, browser, pytestconfig):
    pictures = _pictures(index, pytestconfig.getoption("--suite") == "whole")
    assert len(pictures) > 2
    with visited(browser, index) as visit:
        assert visit.ask(MISPLACED, pictures) == []
        (name, text) = next(iter(pictures.items()))
        moved = re.sub(r'<text class="m" x="[\d.]+"', '<text class="m" x="2"', text)
        assert len(visit.ask(MISPLACED, {name: moved})) > 2


def test_labels_of_wide_pictures_and_maps_are_apart_too(index, browser):
    def of(curves, *, wide=False):
        return figure("", "", curves, linear("x [m]"), logarithmic("y [m]"), legend=True, wide=wide)

    curves = [curve([1.0, 2.0], [k + 1e-3, 1.0], name=f"engine/method-{k}") for k in range(9)]
    drawn = {
        "wide": of(curves, wide=True),
        "map": figure(
            "",
            "",
            [heat([1.0, 2.0], [1.0, 2.0], [[0.0, 1.0], [0.2, 0.4]], 0.5)],
            linear("x [m]"),
            linear("y [m]"),
        ),
    }
    with visited(browser, index) as visit:
        assert visit.ask(MISPLACED, {name: _svg(one) for name, one in drawn.items()}) == []


def _svg(of, *chosen):
    drawn = drawing(of, chosen)
    assert drawn
    return drawn.svg


@pytest.mark.long
def test_a_plot_is_a_picture_until_it_is_pressed(index, browser):
    page = site_files(index)[1].parent / SCENE
    with visited(browser, page) as visit:
        plots = visit.page.locator(".area")
        for plot in plots.all():
            plot.scroll_into_view_if_needed()
        visit.until("[...document.querySelectorAll('.area img')].every((one) => one.naturalWidth)")
        assert not any("plotly" in url for url in visit.requests)
        _pressed(visit, 0)
        _pressed(visit, plots.count() - 1)
        visit.ask("dispatchEvent(new Event('beforeprint'))")
        assert visit.page.locator(".main-svg").count() == 0
        assert visit.page.locator(".area img:visible").count() == plots.count()
        assert visit.console == []


def _pressed(visit, place):
    plot = visit.page.locator(".area").nth(place)
    plot.locator("button").focus()
    visit.page.keyboard.press("Enter")
    plot.locator(".main-svg").first.wait_for()
    assert not plot.locator("img").is_visible()


def test_a_picture_has_the_methods_that_are_chosen_and_their_front():
    fast = curve([1.0, 10.0], [1e-3, 1e-2], method="a/fast", marks=True)
    slow = curve([1.0, 2.0], [1e-6, 1e-4], method="b/slow", marks=True)
    edge = {**curve([1.0], [1.0], name="Pareto front"), "meta": FRONT}
    both = figure("", "", [edge, fast, slow], logarithmic("speed [1]"), logarithmic("error [1]"))
    assert [t["name"] for t in shown(both, ["a/fast"])] == ["Pareto front", "a/fast"]
    assert list(shown(both, ["a/fast"])[0]["x"]) == [10.0, 1.0]
    assert list(shown(both, ["a/fast", "b/slow"])[0]["x"]) == [10.0, 2.0, 1.0]
    for chosen, names in ((["a/fast"], {"a/fast"}), ([], {"a/fast", "b/slow"})):
        drawn = drawing(both, chosen)
        assert {name for name, _, _ in drawn.names} == {"Pareto front", *names}


def test_a_curve_breaks_at_a_gap_and_keeps_its_course():
    x = np.linspace(0.0, 6.0, 300)
    y = np.where(abs(x - 3.0) < 0.1, np.nan, np.sin(x))
    text = _svg(figure("", "", [curve(x, y, colour="#123456")], linear("x [1]"), linear("y [1]")))
    (path,) = re.findall(r'stroke="#123456"[^>]* d="([^"]+)"', text)
    first, second = ([int(n) for n in re.findall(r"-?\d+", run)] for run in path.split("M")[1:])
    assert 10 < len(first) + len(second) < 600
    points = np.cumsum(np.reshape([*first, *second[2:]], (-1, 2)), axis=0)[: len(first) // 2]
    along = 6.0 / (points[-1, 0] - points[0, 0]) * (x[x < 2.9][-1] / 6.0)
    angle = (points[:, 0] - points[0, 0]) * along
    height = (points[0, 1] - points[:, 1]) / (points[0, 1] - points[:, 1].min())
    assert np.max(np.abs(height - np.sin(angle))) < 0.01


def test_pictures_inside_a_page_are_no_files():
    drawn = figure("t", "", [curve([1.0, 2.0], [1.0, 2.0])], linear("x [1]"), linear("y [1]"))
    inside, beside = Plots(), Plots("folder/", "page")
    address, size = inside.picture(drawn, ())
    assert address.startswith("data:image/svg+xml,")
    assert not set('<>"#&') & set(address)
    assert inside.files == {}
    assert size
    address, _ = beside.picture(drawn, ())
    assert beside.files[address.removeprefix("folder/")].decode() == size.svg
    nothing = replace(drawn, traces=({**drawn.traces[0], "x": [None], "y": [None]},))
    assert beside.picture(nothing, ()) == ("", None)


def test_a_curve_ends_in_a_cross_at_the_speed_of_its_largest_step():
    """Dotted from the largest run that is stable, past those that are not; none without a limit."""
    runs = [Point("mujoco/rk4", step, 1e-3 * step, 1e4 / step) for step in (1.0, 0.1, 0.01)]
    methods = {"mujoco/rk4": method("mujoco/rk4")}
    look = styles(list(methods.values()))
    drawn = error_against_cost(runs, {}, methods, look, {"mujoco/rk4": 0.3, "ode/rk4": 0.2})
    *_, line, cross = drawn.traces
    assert line["x"] == [1e4, 3e4]
    assert cross["x"] == [3e4]
    assert line["y"] == [1e-4, 1e-4]
    assert cross["y"] == [1e-4]
    assert cross["marker"]["symbol"] == "x"
    assert "A cross" in drawn.caption
    without = error_against_cost(runs, {}, methods, look, {})
    assert len(without.traces) == len(drawn.traces) - 2
    assert "cross" not in without.caption
