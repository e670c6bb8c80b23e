"""The replays' controls in a real browser: buttons, keys, magnifier, less motion."""

import json

import numpy as np
import pytest
from playwright.sync_api import expect

from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.replay.runs import shown_runs
from plumbob.tests.replay.all_replays import plan, recorded, replay_of, write
from plumbob.tests.replay.in_browser import FRACTION, found, opened, set_time, stopped

SHOWN = ("cone-pendulum/rotating-base", "capsule-turn/0.3", "simple-pendulum/free-large")
NAME = SHOWN[0]
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
FIRST = [0xC9, 0x57, 0x00]  # of the style sheet, on a light page
RING = 8.5  # [pixel] radius of the first run's mark


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return write([replay_of(name) for name in SHOWN], tmp_path_factory.mktemp("controls"))


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
    assert then == pytest.approx(0.4 / 8, abs=0.004)  # of what plays in eight seconds
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


def test_the_magnifier_draws_errors_by_its_factor(page):
    """The first run's mark: where factor times the recorded error puts it, and where it is not at
    another factor."""
    name = SHOWN[2]
    factor = 1000
    figure = stopped(page, name)
    figure.locator("[data-layer='1']").check()
    case = case_of(find_scene(name))
    data = json.loads(replay_of(name).data)
    first = shown_runs(StudyPlan("quick", (case.scene,), plan().methods), case.scene)[0]
    run = recorded(name).answer(first.run)
    time = FRACTION * data["seconds"]
    exact = case.reference.observe(np.append(run.times, time))["theta"]
    apart = np.interp(time, run.times, run.observables["theta"] - exact[:-1])
    picture = json.loads(figure.locator(".live canvas").get_attribute("data-plan"))

    def ring(times):
        spot = 1j * case.problem.length * np.exp(-1j * (exact[-1] + times * apart))
        x = picture["x"] + picture["scale"] * spot.real
        y = picture["y"] + picture["scale"] * spot.imag
        ring = [x, y, RING, FIRST]
        return figure.locator(".live canvas").evaluate(COVERED, ring)

    figure.locator("select.factor").select_option(str(factor))
    assert ring(factor) > 0.9
    assert max(ring(1), ring(factor // 2), ring(2 * factor)) < 0.7
    figure.locator("select.factor").select_option("1")
    assert ring(1) > 0.9
    assert ring(factor) < 0.7
