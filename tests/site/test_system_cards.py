"""The cards of systems on the index: a thumbnail that moves, the default and the best error."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.reports.records.page_records import records_of
from plumbob.reports.view.method_results import results_of
from plumbob.reports.view.page import fill_page
from plumbob.reports.view.site.system_cards import system_card, thumbnails
from plumbob.reports.view.site.writing import write_site
from plumbob.tests.replay.in_browser import opened
from plumbob.tests.site import whole_profile
from plumbob.tests.site.whole_profile import small
from plumbob.tests.support.studies import SCENE, quick

# The picture of a thumbnail, and whether anything is drawn on it
SHOWN = "(canvas) => canvas.toDataURL()"
DRAWN = """(canvas) => {
  const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return data.filter((value, i) => i % 4 === 3 && value > 0).length / (data.length / 4);
}"""


def card(default=0.1, better=0.01, **changes):
    """The card of a scene with these relative errors of MuJoCo's Euler and, as `mujoco/rk4`, of
    another method, whose result has `changes`."""
    results = {r.name: r for (name, _), r in _measured().items() if name == SCENE}
    euler = _with_errors(results["mujoco/euler"], default)
    rk4 = replace(euler, method=find_method("mujoco/rk4"))
    return system_card([euler, replace(_with_errors(rk4, better), **changes)], None)


def _measured():
    study = quick()
    return results_of(study, records_of(study))


def _with_errors(result, error):
    """A result with this relative error of every quantity at every step."""
    scales = {quantity.observable: quantity.scale for quantity in result.quantities}
    runs = tuple(
        replace(
            run,
            errors={
                name: replace(own, largest=error * scales[name], end=error * scales[name])
                for name, own in run.errors.items()
                if name in scales
            },
        )
        for run in result.series.measurements
    )
    return replace(result, series=replace(result.series, measurements=runs))


def test_a_card_names_the_setting_with_the_smallest_error():
    shown = card()
    assert (shown.default.text, shown.best.text, shown.method) == ("10 %", "1 %", "mujoco/rk4")


@pytest.mark.parametrize(
    "of",
    [
        {"better": 0.06},  # hardly smaller
        {"better": 0.2},
        {"changed": "known"},  # a known limit
        {"changed": "surrogate"},
        {"changed": "another engine"},
    ],
    ids=str,
)
def test_a_setting_that_is_not_clearly_better_is_not_named(of):
    changes = {}
    own = find_method("mujoco/rk4")
    if of.get("changed") == "known":
        (result,) = [
            r for (n, m), r in _measured().items() if (n, m) == (SCENE, "mujoco/euler")
        ]
        judged = replace(result.judged, verdict="off-prediction", standing="known limit")
        changes = {"judged": judged}
    elif of.get("changed") == "surrogate":
        changes = {"method": replace(own, surrogate="a reduced model")}
    elif of.get("changed"):
        changes = {"method": find_method("ode/rk4")}
    shown = card(better=of.get("better", 0.01), **changes)
    assert (shown.best, shown.method) == (None, "")


def test_no_thumbnail_is_no_file():
    assert thumbnails({"cone-pendulum": card()}) == ""


@pytest.mark.rare
def test_a_study_without_drawings_is_shown_without_them():
    """A study that was stored before its scenes were drawn has no drawings."""
    common = whole_profile.shown().common
    views = [_without_drawings(view) for view in common["views"]]
    index = fill_page(
        "index.html.jinja",
        **{**common, "views": views, "thumbnails": ""},
        inside_pages=(),
        search="",
    )
    assert "<canvas" not in index
    assert "A steel cone hangs by its tip" in index


def _without_drawings(view):
    """The view of a system whose scenes have no replays."""
    scenes = [SimpleNamespace(**{**vars(scene), "replay": None}) for scene in view.scenes]
    card = replace(view.card, thumbnail="")
    return SimpleNamespace(**{**vars(view), "scenes": scenes, "card": card})


@pytest.mark.long
@pytest.mark.parametrize("motion", ["no-preference", "reduce"])
def test_a_thumbnail_moves_under_a_pointer(motion, browser, tmp_path):
    """It is still before and after, and always for a reader who prefers less motion."""
    index = write_site(small(), tmp_path)
    for page in opened(browser, index, reduced_motion=motion):
        canvas = page.locator(".systems canvas").first
        canvas.scroll_into_view_if_needed()
        page.locator(".systems canvas[data-plan]").first.wait_for()
        assert canvas.evaluate(DRAWN) > 0.03
        still = canvas.evaluate(SHOWN)
        canvas.hover()
        page.wait_for_timeout(400)
        assert (canvas.evaluate(SHOWN) == still) == (motion == "reduce")
        page.mouse.move(0, 0)
        page.wait_for_timeout(200)
        assert canvas.evaluate(SHOWN) == still
        card = page.locator(".systems li").first.inner_text()
        assert "A steel cone hangs by its tip" in card
        assert " → " in card
