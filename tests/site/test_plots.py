"""Every plot is a picture with its labels inside it and apart, and plotly's where pressed."""

import re
from functools import cache
from itertools import combinations

import numpy as np
import pytest

from plumbob.engines.registry import methods as find_methods
from plumbob.reports.advice.work_precision import RunPoint
from plumbob.reports.view import palette, plotly_figure
from plumbob.reports.view.drawing import separated_ticks, svg_drawing
from plumbob.reports.view.plots import error_against_cost
from plumbob.tests.support.browser import visited
from plumbob.tests.support.page_document import plotted, site_files

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


def test_ticks_that_would_touch_on_a_telephone_are_left_out():
    ticks = [
        (0.0, "0.001"),
        (140.0, "0.002"),
        (222.0, "0.003"),
        (280.0, "0.004"),
        (325.0, "0.005"),
    ]
    assert separated_ticks(ticks) == ticks[:-1]


@pytest.mark.long
def test_every_label_is_inside_its_picture_and_apart(index, browser, pytestconfig):
    pictures = _pictures(index, pytestconfig.getoption("--suite") != "short")
    assert len(pictures) > 2
    with visited(browser, index) as visit:
        assert visit.ask(MISPLACED, pictures) == []
        (name, text) = next(iter(pictures.items()))
        moved = re.sub(r'<text class="m" x="[\d.]+"', '<text class="m" x="2"', text)
        assert len(visit.ask(MISPLACED, {name: moved})) > 2


# Machado, Oliveira, Fernandes 2009: what a reader without green cones sees of linear sRGB
DEUTERANOPE = np.array(
    [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ]
)
TO_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
# Two colours side by side are just discerned at 2 units of CIELAB; thin lines that are not side by
# side need several times as much.
APART = 15.0


def _lab(colour, reader):
    """A colour "#rrggbb" in CIELAB, as a `reader` sees it: a deuteranope or another one."""
    given = np.array(list(bytes.fromhex(colour[1:]))) / 255.0
    linear = np.where(given <= 0.04045, given / 12.92, ((given + 0.055) / 1.055) ** 2.4)
    seen = DEUTERANOPE @ linear if reader == "deuteranope" else linear
    x, y, z = TO_XYZ @ np.clip(seen, 0.0, 1.0) / (0.95047, 1.0, 1.08883)
    fx, fy, fz = (np.cbrt(v) if v > 0.008856 else 7.787 * v + 16.0 / 116.0 for v in (x, y, z))
    return np.array([116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)])


@cache
def _apart(one, other, reader="deuteranope"):
    """The distance of two colours to a reader, in units of CIELAB."""
    return np.linalg.norm(_lab(one, reader) - _lab(other, reader))


def test_colours_are_apart_for_a_deuteranope():
    colours = {*palette.COLOURS, palette.GREY, palette.INK}
    assert len(colours) == len(palette.COLOURS) + 2
    assert [pair for pair in combinations(colours, 2) if _apart(*pair) < APART] == []
    # The olive and the orange-red of an earlier palette are far apart for others.
    assert _apart("#8f9a1c", "#d55e00") < APART
    assert _apart("#8f9a1c", "#d55e00", "another") > 4.0 * APART
    used = {style.colour for style in palette.styles(_names()).values()}
    assert used <= colours


def _names():
    return [method.name for method in find_methods("*")]


def test_methods_of_one_colour_have_markers_of_their_own():
    looks = [(style.colour, style.marker) for style in palette.styles(_names()).values()]
    assert len(looks) > 50
    assert len(set(looks)) == len(looks)


@pytest.mark.parametrize("marker", palette.ALL_MARKERS)
def test_every_marker_is_seen(marker):
    """An open circle was the round end of a line without length, in a thin line."""
    style = palette.Style(palette.BLUE, marker, 6.0)
    marks = plotly_figure.curve([1, 2], [1, 2], style, marks=True, lines=False)
    axes = plotly_figure.linear("x"), plotly_figure.linear("y")
    (path,) = svg_drawing(plotly_figure.figure("", "", [marks], *axes)).paths
    assert path.width >= 60.0 or "h0" not in path.d


def _alike(figure):
    """Pairs of curves of a figure that colour, markers, dashes and width do not tell apart.
    Predictions are left out: each lies on the marks of its own curve."""
    named = {}
    for trace in figure["data"]:
        shown = trace.get("name") and trace.get("showlegend", True) and "opacity" not in trace
        if shown and "line" in trace and trace["line"]["color"] != palette.INK:
            line, marker = trace["line"], trace.get("marker", {}).get("symbol")
            named[trace["name"]] = (line["color"], marker, line["dash"], line["width"])
    return [
        (figure["layout"]["yaxis"]["title"]["text"], one, other)
        for (one, a), (other, b) in combinations(named.items(), 2)
        if _apart(a[0], b[0]) < APART and a[1:] == b[1:]
    ]


@pytest.mark.long
def test_curves_are_distinct_and_dots_are_predictions(index):
    figures = [figure for file in site_files(index) for figure in plotted(file)]
    assert len(figures) > 100
    assert [pair for figure in figures for pair in _alike(figure)] == []
    traces = [trace for figure in figures for trace in figure["data"] if "line" in trace]
    dotted = [trace for trace in traces if trace["line"]["dash"] == "dot"]
    inked = [trace for trace in traces if trace["line"]["color"] == palette.INK]
    assert dotted == inked != []


def test_the_band_is_the_front_of_the_methods_that_are_shown():
    """A method that is hidden at first beats them, and is not counted."""
    methods = find_methods("mujoco/euler,mujoco/rk4")
    points = [
        RunPoint("mujoco/euler", 1e-3, 1e-2, 1e6),
        RunPoint("mujoco/rk4", 1e-3, 1e-6, 1e5),
    ]
    figure = error_against_cost(
        points, {m.name: m for m in methods}, palette.styles(_names()), {}, ["mujoco/euler"]
    )
    (band,) = (trace for trace in figure.traces if trace.get("meta") == "front")
    assert (band["x"], band["y"]) == ([1e3], [1e-2])
    drawn = svg_drawing(figure, ["mujoco/euler"])
    assert [name[0] for name in drawn.names] == ["Pareto front among the methods shown"]
    assert [name.text for name in drawn.point_names] == ["● mujoco/euler"]


def test_a_zero_has_a_tick_that_says_so():
    runs = plotly_figure.curve([1, 2], plotly_figure.positive_magnitudes([0.0, 1e-3]))
    axes = plotly_figure.linear("step"), plotly_figure.logarithmic("error")
    up = svg_drawing(plotly_figure.figure("", "", [runs], *axes)).up
    assert [text for _, text in up] == ["0", "10⁻³"]
    none = plotly_figure.curve([1, 2], [1e-4, 1e-3])
    shown = svg_drawing(plotly_figure.figure("", "", [none], *axes))
    assert "0" not in [text for _, text in shown.up]


def test_an_orbit_has_no_corners():
    """Between points a smooth curve is within a hundredth of the chord's distance."""
    angles = np.linspace(0.0, 2.0 * np.pi, 13)
    circle = plotly_figure.curve(np.cos(angles), np.sin(angles), smooth=True)
    axes = plotly_figure.linear("x"), plotly_figure.linear("y", scaleanchor="x")
    drawn = svg_drawing(plotly_figure.figure("", "", [circle], *axes))
    numbers = np.array(re.findall(r"-?\d+", drawn.paths[0].d), dtype=float).reshape(-1, 2) / 10
    middle = (drawn.x.along(0.0), drawn.y.along(0.0))
    radius = abs(1.0 / drawn.x.scale)
    start, one, two, end = numbers[3:7]  # of the second of twelve pieces
    halfway = (start + 3 * one + 3 * two + end) / 8
    chord = radius * (1.0 - np.cos(np.pi / 12))
    assert abs(np.hypot(*(halfway - middle)) - radius) < 0.1 * chord


@pytest.mark.long
def test_a_plot_is_a_picture_until_it_is_pressed_or_under_a_mouse(index, browser):
    page = site_files(index)[1].parent / SCENE
    with visited(browser, page) as visit:
        plots = visit.page.locator(".area")
        for plot in plots.all():
            plot.scroll_into_view_if_needed()
        visit.until(
            "[...document.querySelectorAll('.area img')].every((one) => one.naturalWidth)"
        )
        assert not any("plotly" in url for url in visit.requests)
        _pressed(visit, 0)
        _pressed(visit, plots.count() - 1)
        plots.nth(1).hover()
        plots.nth(1).locator(".main-svg").first.wait_for()
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
