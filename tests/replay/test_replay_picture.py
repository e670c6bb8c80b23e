"""The replays in a real browser: the canvas has the body where the exact answer puts it."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.replay import PICTURES
from plumbob.reports.analyses.replay.picture import AZIMUTH, ELEVATION
from plumbob.reports.analyses.replay.samples import encode_samples
from plumbob.tests.replay.all_replays import decoded, plan, replay_of, write
from plumbob.tests.replay.in_browser import FRACTION, opened, stopped

NAMES = [scene.name for scene in plan().scenes if system_of(scene).family in PICTURES]
ONE_OF_EACH = (
    "capsule-coast/spin",
    "capsule-hold/0.999",
    "capsule-line/heading-030",
    "capsule-plan/near-free",
    "capsule-train/ten",
    "capsule-turn/0.3",
    "cone-pendulum/rotating-base",
    "free-body/flip",
    "linear-pendulum/overdamped",
    "simple-pendulum/free-small",
)
PIXEL = 0.5  # the centre of a disc of whole pixels is known to better than this
MOVED = ("theta", "x", "y", "heading", "attitude_x")
CENTRE = """(canvas, [rect, colour]) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext("2d", {willReadFrequently: true});
  pen.drawImage(canvas, 0, 0);
  const [x0, y0, w, h] = rect.map(Math.round), seen = pen.getImageData(x0, y0, w, h).data;
  let count = 0, x = 0, y = 0;
  for (let i = 0; i < w * h; i += 1) {
    if (seen[4 * i + 3] < 255 || colour.some((c, k) => Math.abs(seen[4 * i + k] - c) > 2)) continue;
    count += 1; x += i % w + 0.5; y += Math.floor(i / w) + 0.5;
  }
  return count ? [x0 + x / count, y0 + y / count, count] : null;
}"""
EXACT = [0x2B, 0x33, 0x3B]  # --exact of the style sheet, on a light page


@pytest.fixture(scope="module")
def page(browser, pytestconfig, tmp_path_factory):
    """A page with the replays, opened by a reader who prefers less motion."""
    shown = [replay_of(name) for name in _names(pytestconfig)]
    file = write(shown, tmp_path_factory.mktemp("replays"))
    yield from opened(browser, file)


@pytest.fixture(scope="module")
def shifted(browser, tmp_path_factory):
    """The same with motions that are shifted by a hundredth of their range."""
    wrong = [_shifted(replay_of(name)) for name in ONE_OF_EACH]
    yield from opened(browser, write(wrong, tmp_path_factory.mktemp("shifted")))


def _shifted(shown):
    """A replay whose exact motion is shifted by 1 % of the picture, or of its range."""
    data = json.loads(shown.data)
    layer = data["layers"][0]
    for name in MOVED:
        if name in layer["channels"]:
            values = decoded(layer["channels"][name], layer["count"])
            size = data["size"] if name in ("x", "y") else float(np.ptp(values))
            layer["channels"][name] = encode_samples(values + 0.01 * size)
    return replace(shown, data=json.dumps(data))


def misplaced(figure, name):
    """Whether the mark is not where the exact answer puts it, within PIXEL."""
    case = case_of(find_scene(name))
    data = json.loads(replay_of(name).data)
    canvas = figure.locator(".live canvas")
    picture = json.loads(canvas.get_attribute("data-plan") or "")["picture"]
    across, up = place(case, FRACTION * data["seconds"])
    area = (0, 0, picture["width"], picture["height"])
    spot = picture["x"] + picture["scale"] * across, picture["y"] - picture["scale"] * up
    return misses(canvas, area, spot) > 0.0


def misses(canvas, area, wanted):
    """How far [pixel] the centre of what has the exact answer's colour is from `wanted`; 0 within
    PIXEL. A mark at the edge of a chart is cut off there, and is not looked at."""
    x0, y0, w, h = area
    if min(wanted[0] - x0, x0 + w - wanted[0], wanted[1] - y0, y0 + h - wanted[1]) < 15:
        return 0.0
    found = canvas.evaluate(CENTRE, [area, EXACT])
    if found is None:
        return math.inf
    apart = math.hypot(found[0] - wanted[0], found[1] - wanted[1])
    return apart if apart > PIXEL else 0.0


def place(case, time):
    """Where the exact answer has the marked point at `time` [s]: right and up [m]."""
    seen = {n: float(v[0]) for n, v in case.reference.observe(np.array([time])).items()}
    if case.system.family == "simple_pendulum":
        length = case.problem.length
        return length * math.sin(seen["theta"]), -length * math.cos(seen["theta"])
    if case.system.family == "cone_pendulum":
        return centre_of_mass(case, seen["theta"], time)
    if case.system.family == "free_body":
        return corner_of_box(case, seen)
    setup = case.problem.setup
    if "displacement" in seen:
        spot = seen["displacement"] * np.exp(1j * (setup.heading + setup.direction))
    else:
        spot = complex(seen["x"], seen["y"]) * np.exp(1j * setup.heading)
    return spot.real, spot.imag


def corner_of_box(case, seen):
    """Where the camera sees the corner of the free body's box: right and up, of its distance from
    the centre."""
    x, y, z = case.problem.inertia
    half = np.sqrt([y + z - x, x + z - y, x + y - z])
    turn = Rotation.from_quat([seen[f"attitude_{axis}"] for axis in "wxyz"], scalar_first=True)
    return seen_by_camera(*turn.apply(half / np.linalg.norm(half)))


def centre_of_mass(case, theta, time):
    """Where the camera sees the cone's centre of mass: right and up [m]."""
    problem = case.problem
    com = case.problem.body.com_distance
    x = problem.pivot_x
    y = problem.pivot_y + com * math.sin(theta)
    z = problem.pivot_z - com * math.cos(theta)
    turn = problem.platform_rate * time
    x, y = x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn)
    return seen_by_camera(x, y, z)


def seen_by_camera(x, y, z):
    """A place in the world as the camera sees it: right and up."""
    away = x * math.cos(AZIMUTH) + y * math.sin(AZIMUTH)
    right = y * math.cos(AZIMUTH) - x * math.sin(AZIMUTH)
    return right, z * math.cos(ELEVATION) - away * math.sin(ELEVATION)


def _names(config):
    """Every scene in the full profile; else one of each system, which is drawn as the others."""
    return NAMES if config.getoption("--profile") == "full" else ONE_OF_EACH


def pytest_generate_tests(metafunc):
    if metafunc.definition.name == "test_the_body_is_where_the_exact_answer_puts_it":
        metafunc.parametrize("name", _names(metafunc.config))


@pytest.mark.long
def test_the_body_is_where_the_exact_answer_puts_it(name, page):
    assert not misplaced(stopped(page, name), name)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", ONE_OF_EACH)
def test_a_motion_shifted_by_a_hundredth_is_misplaced(name, shifted):
    assert misplaced(stopped(shifted, name), name)
