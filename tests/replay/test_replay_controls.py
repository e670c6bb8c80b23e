"""The replays' controls in a real browser: buttons, keys, magnifier, less motion, paper."""

import json
import math

import numpy as np
import pytest
from playwright.sync_api import expect

from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.replay.runs import shown_runs
from plumbob.tests.replay.all_replays import plan, recorded, replays, write
from plumbob.tests.replay.in_browser import FRACTION, found, opened, set_time, stopped

SHOWN = ("cone-pendulum/rotating-base", "capsule-turn/0.3", "simple-pendulum/free-large")
NAME = SHOWN[0]  # half a second, at a twentieth of real time
LAST = 10_000  # of the time's slider
COVERED = """(canvas, [x, y, radius, colour]) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext("2d", {willReadFrequently: true});
  pen.drawImage(canvas, 0, 0);
  let count = 0;
  for (let k = 0; k < 90; k += 1) {
    const a = 2 * Math.PI * k / 90;
    const [px, py] = [x + radius * Math.cos(a), y + radius * Math.sin(a)];
    const [r, g, b, alpha] = pen.getImageData(px, py, 1, 1).data;
    count += alpha > 100 && Math.hypot(r - colour[0], g - colour[1], b - colour[2]) < 60;
  }
  return count / 90;
}"""
PICTURE = """(canvas, like) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = like || [canvas.width, canvas.height];
  copy.getContext("2d").drawImage(canvas, 0, 0);
  return [copy.width, copy.height, copy.toDataURL()];
}"""
FIRST, FRICTION = [0xC9, 0x57, 0x00], [0x9A, 0x3D, 0x7F]  # of the style sheet, on a light page
RING = 8.5  # [pixel] radius of the first run's mark


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return write([replays()[name] for name in SHOWN], tmp_path_factory.mktemp("controls"))


@pytest.fixture(scope="module")
def still(browser, file):
    """Opened by a reader who prefers less motion."""
    yield from opened(browser, file)


@pytest.fixture
def page(still):
    """The same, with nothing left that plays."""
    yield still
    still.evaluate(PAUSE)


PAUSE = """() => document.querySelectorAll(".play").forEach((one) => {
  if (one.textContent === "Pause") one.click();
})"""


@pytest.fixture
def moving(browser, file):
    """Opened by a reader who has nothing against motion; its clock runs when it is set to."""
    yield from opened(browser, file, clocked, reduced_motion="no-preference")


@pytest.fixture(scope="module")
def pausable(browser, file):
    """The same for tests that begin with what is `paused`."""
    yield from opened(browser, file, clocked, reduced_motion="no-preference")


def clocked(page):
    """Give a page a clock of its own, which stands still unless it is run."""
    page.clock.install(time=0)
    page.clock.pause_at(1000)


def paused(page, name):
    """The replay of a scene at its start and first speed, where it may have begun to play by
    itself."""
    figure = found(page, name)
    figure.locator("select.speed").evaluate(FIRST_CHOSEN)
    figure.locator("select.speed").focus()
    if figure.locator(".play").inner_text() == "Pause":
        figure.locator(".play").click()
    set_time(figure, 0.0)
    return figure


FIRST_CHOSEN = """(choice) => {
  for (const option of choice.options) option.selected = option.defaultSelected;
  choice.dispatchEvent(new Event("change"));
}"""


def time_of(figure):
    """Where the time's slider is, as a fraction."""
    return float(figure.locator("input[type=range]").input_value()) / LAST


def test_the_button_plays_pauses_and_begins_again_at_the_end(pausable):
    figure = paused(pausable, NAME)
    figure.get_by_role("button", name="Play").click()
    pausable.clock.run_for(400)
    figure.get_by_role("button", name="Pause").click()
    then = time_of(figure)
    assert then == pytest.approx(0.4 / 20 / 0.5, abs=0.004)  # 1/20 of real time, of half a second
    pausable.clock.run_for(400)
    assert time_of(figure) == then
    assert "Paused at" in figure.locator("[role=status]").inner_text()
    set_time(figure, 0.99)
    figure.get_by_role("button", name="Play").click()
    pausable.clock.run_for(1000)
    assert time_of(figure) == 1.0
    figure.get_by_role("button", name="Play").click()
    pausable.clock.run_for(400)
    assert 0.0 < time_of(figure) < 0.1


@pytest.mark.long
@pytest.mark.parametrize("place", ["input[type=range]", ".play"])
def test_keys_move_it(place, page):
    figure = found(page, NAME)
    figure.locator(place).focus()
    for key, wanted in (
        ("End", 1.0),
        ("ArrowLeft", 0.99),
        ("Home", 0.0),
        ("ArrowRight", 0.01),
        ("PageUp", 0.11),
    ):
        page.keyboard.press(key)
        assert time_of(figure) == pytest.approx(wanted, abs=1e-4), key
    page.keyboard.press(" ")
    expect(figure.locator(".play")).to_have_text("Pause")
    page.keyboard.press(" ")
    expect(figure.locator(".play")).to_have_text("Play")


@pytest.mark.long
def test_it_starts_by_itself_once_and_stops_out_of_sight(moving):
    figure = found(moving, NAME)
    for in_sight, wanted in ((True, "Pause"), (False, "Play"), (True, "Play")):
        if in_sight:
            figure.locator(".live canvas").scroll_into_view_if_needed()
        else:
            moving.evaluate("scrollTo(0, document.body.scrollHeight)")
        moving.evaluate(FRAMES)  # what is in sight is looked at once a frame
        expect(figure.locator(".play")).to_have_text(wanted)
        moving.clock.run_for(400)
        if wanted == "Pause":
            assert time_of(figure) > 0.0
    then = time_of(figure)
    moving.clock.run_for(400)
    assert time_of(figure) == then


# Resolved after the observers of what is in sight have been called.
FRAMES = """() => new Promise((done) => {
  const seen = new IntersectionObserver(() => { seen.disconnect(); done(); });
  seen.observe(document.querySelector("h1"));
})"""


@pytest.mark.long
def test_less_motion_is_no_motion_by_itself_and_twelve_steps(browser, file):
    for page in opened(browser, file, clocked):
        figure = found(page, NAME)
        figure.locator(".live canvas").scroll_into_view_if_needed()
        page.evaluate(FRAMES)
        page.clock.run_for(2000)
        assert time_of(figure) == 0.0
        figure.locator(".play").click()
        for seconds, steps in ((0.5, 0), (0.7, 1), (0.5, 1), (0.5, 2)):
            page.clock.run_for(round(1000 * seconds))
            assert time_of(figure) == pytest.approx(steps / 12, abs=1e-3)


@pytest.mark.parametrize(("name", "factor"), [(SHOWN[0], 10), (SHOWN[2], 100)])
def test_the_magnifier_draws_errors_by_its_factor(name, factor, page):
    """The first run's mark in the chart of the phase plane: where factor times the recorded error
    puts it, and where it is not at another factor."""
    figure = stopped(page, name)
    figure.locator("[data-layer='1']").check()
    data, rect = json.loads(replays()[name].data), plan_of(figure)["charts"][0]
    left, right, bottom, top = rect["box"]

    def ring(times):
        exact, apart = states(name, FRACTION * data["seconds"])
        theta, rate = exact + times * apart
        if data["charts"][0]["turns"]:
            theta = math.remainder(theta, 2.0 * math.pi)
        x = rect["x"] + rect["w"] * (theta - left) / (right - left)
        y = rect["y"] + rect["h"] * (top - rate) / (top - bottom)
        return covered(figure, x, y, RING, FIRST)

    figure.locator("select.factor").select_option(str(factor))
    assert ring(factor) > 0.9
    assert max(ring(1), ring(factor // 2), ring(2 * factor)) < 0.7
    figure.locator("select.factor").select_option("1")
    assert ring(1) > 0.9
    assert ring(factor) < 0.7


def states(name, time):
    """Angle and rate of the exact answer, and what the first run differs by, at `time` [s]."""
    case, scene = case_of(find_scene(name)), find_scene(name)
    first = shown_runs(StudyPlan("quick", (scene,), plan().methods), scene)[0]
    run = recorded().answer(first.run)
    names = ("theta", "theta_dot")
    seen, now = case.reference.observe(run.times), case.reference.observe(np.array([time]))
    apart = [np.interp(time, run.times, run.observables[n] - seen[n]) for n in names]
    return np.array([float(now[n][0]) for n in names]), np.array(apart)


def test_friction_points_against_the_sliding_of_each_foot(page):
    """The middle of each arrow has its colour; what points the other way, or is turned by a
    sixth of a turn, has not."""
    name = "capsule-turn/0.3"
    figure = stopped(page, name)
    case, data = case_of(find_scene(name)), json.loads(replays()[name].data)
    picture = plan_of(figure)["picture"]
    now = case.reference.observe(np.array([FRACTION * data["seconds"]]))
    seen = {channel: float(values[0]) for channel, values in now.items()}
    body, place = case.problem.setup.capsule, complex(seen["x"], seen["y"])
    for i, foot in enumerate(np.asarray(body.supports) @ [1.0, 1j]):
        arm = foot * np.exp(1j * seen["body_angle"])
        sliding = complex(seen["velocity_x"], seen["velocity_y"]) + 1j * seen["heading_rate"] * arm
        arrow = -data["geometry"]["arrow"] * seen[f"normal_force_{i + 1}"] / body.weight
        arrow *= sliding / abs(sliding)
        for turn, coloured in ((0.0, True), (math.pi, False), (1.0, False), (-1.0, False)):
            for part in (0.5, 0.9):
                spot = place + arm + part * arrow * np.exp(1j * turn)
                x = picture["x"] + picture["scale"] * spot.real
                y = picture["y"] - picture["scale"] * spot.imag
                assert (covered(figure, x, y, 0.5, FRICTION) > 0.5) == coloured, (i, turn, part)


def plan_of(figure):
    """Where a replay's canvas has its parts."""
    return json.loads(figure.locator(".live canvas").get_attribute("data-plan") or "")


def covered(figure, *ring):
    """The part of a ring on a replay's canvas (x, y, radius, colour) that has this colour."""
    part = figure.locator(".live canvas").evaluate(COVERED, list(ring))
    return part


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("name", "part", "wanted", "unwanted"),
    [
        ("capsule-line/ca1", 0.1, {"A₁", "A₂", "A₃", "C", "Q", "w₁"}, {"w₂", "θ"}),
        ("capsule-line/ca1", 0.3, {"A₁", "A₂", "A₃", "C", "Q", "w₂"}, {"w₁"}),
        ("capsule-turn/0.3", 0.1, {"A₁", "A₂", "A₃", "C", "Q", "w"}, {"w₁", "w₂"}),
        ("cone-pendulum/rotating-base", 0.3, {"θ", "S", "ω"}, {"C"}),
        ("cone-pendulum/resting-base", 0.3, {"θ", "S"}, {"ω"}),
        ("simple-pendulum/free-large", 0.3, {"θ"}, {"S"}),
        ("capsule-hold/0.999", 0.3, {"A₁", "C", "Q", "gravity"}, {"w"}),
    ],
)
def test_what_is_drawn_is_labelled(name, part, wanted, unwanted, labelled):
    figure = found(labelled, name)
    labelled.evaluate("written.clear()")
    set_time(figure, part)
    written = set(labelled.evaluate("[...written]"))
    assert wanted <= written
    assert not unwanted & written


WRITTEN = """globalThis.written = new Set();
const own = CanvasRenderingContext2D.prototype.fillText;
CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
  written.add(text);
  return own.call(this, text, ...rest);
};"""


@pytest.fixture(scope="module")
def labelled(browser, tmp_path_factory):
    """A page that keeps what is written on its canvases."""
    file = write(list(replays().values()), tmp_path_factory.mktemp("labelled"))
    yield from opened(browser, file, lambda page: page.add_init_script(WRITTEN))


def test_the_printed_page_has_six_moments(page):
    """As they are drawn for the screen, when the time is theirs and errors are as large."""
    name = SHOWN[2]
    figure, shown = found(page, name), replays()[name]
    strip, pictures = figure.locator(".replay-strip"), figure.locator(".moment canvas")
    assert not strip.is_visible()
    page.emulate_media(media="print")
    assert strip.is_visible()
    assert not figure.locator(".live").is_visible()
    moments = list(shown.moments.values())
    assert pictures.count() == len(moments) == 6
    printed = [picture.evaluate(PICTURE) for picture in pictures.all()]
    assert len({drawn for *_, drawn in printed}) == 6
    page.emulate_media(media="screen")
    assert shown.magnified > 1
    figure.locator(".factor").select_option(str(shown.magnified))
    for moment, picture in zip(moments, printed, strict=True):
        set_time(figure, moment / shown.seconds)
        assert figure.locator(".live canvas").evaluate(PICTURE, picture[:2]) == picture
