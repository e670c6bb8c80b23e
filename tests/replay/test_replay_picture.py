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
from plumbob.reports.analyses.replay.cone import AZIMUTH, ELEVATION
from plumbob.reports.analyses.replay.samples import coded
from plumbob.tests.replay.all_replays import decoded, plan, replays, write
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
MOVED = ("theta", "theta_dot", "x", "y", "heading", "attitude_x", "angular_velocity_x")
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
def page(browser, tmp_path_factory):
    """A page with every replay, opened by a reader who prefers less motion."""
    file = write(list(replays().values()), tmp_path_factory.mktemp("replays"))
    yield from opened(browser, file)


@pytest.fixture(scope="module")
def shifted(browser, tmp_path_factory):
    """The same with motions that are shifted by a hundredth of their range."""
    wrong = [_shifted(replays()[name]) for name in ONE_OF_EACH]
    yield from opened(browser, write(wrong, tmp_path_factory.mktemp("shifted")))


def _shifted(shown):
    """A replay whose exact motion is shifted by 1 % of its range; one at rest by 1 % of the
    millimetre that it is held against."""
    data = json.loads(shown.data)
    layer = data["layers"][0]
    for name in MOVED:
        if name in layer["channels"]:
            values = decoded(layer["channels"][name], layer["count"])
            still = 1e-3 if name in ("x", "y") and shown.scene.startswith("capsule-hold") else 0.0
            shift = 0.01 * (float(np.ptp(values)) or still)
            layer["channels"][name] = coded(values + shift)
    return replace(shown, data=json.dumps(data))


def misplaced(figure, name):
    """The marks that are not where the exact answer puts them, within PIXEL."""
    case, data = case_of(find_scene(name)), json.loads(replays()[name].data)
    time = FRACTION * data["seconds"]
    canvas = figure.locator(".live canvas")
    drawn = json.loads(canvas.get_attribute("data-plan") or "")
    exact = places(case, time)
    wrong = []
    picture, spot = drawn["picture"], exact["picture"]
    if apart := misses(
        canvas,
        (0, 0, picture["width"], picture["height"]),
        (picture["x"] + picture["scale"] * spot[0], picture["y"] - picture["scale"] * spot[1]),
    ):
        wrong.append(f"picture: {apart:.2f} pixels")
    for chart, rect in zip(data["charts"], drawn["charts"], strict=True):
        if chart["exact_alone"]:
            continue  # three marks, which may cover each other
        left, right, bottom, top = rect["box"]
        if chart["seconds"]:
            left = min(max(time - chart["seconds"] / 2, 0.0), data["seconds"] - chart["seconds"])
            right = left + chart["seconds"]
        x = time if chart["x"] == "t" else exact[chart["x"]]
        if chart["turns"]:
            x -= 2.0 * math.pi * round(x / (2.0 * math.pi))
        across = rect["x"] + rect["w"] * (x - left) / (right - left)
        down = rect["y"] + rect["h"] * (top - exact[chart["y"][0]]) / (top - bottom)
        area = (rect["x"] - 8, rect["y"] - 8, rect["w"] + 16, rect["h"] + 16)
        if apart := misses(canvas, area, (across, down)):
            wrong.append(f"{chart['label']}: {apart:.2f} pixels")
    return wrong


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


def places(case, time):
    """What the exact answer says at `time` [s]: channels by name, and the marked point [m]."""
    seen = {n: float(v[0]) for n, v in case.reference.observe(np.array([time])).items()}
    if case.system.family == "simple_pendulum":
        length = case.problem.length
        spot = (length * math.sin(seen["theta"]), -length * math.cos(seen["theta"]))
        return {**seen, "x": spot[0], "y": spot[1], "picture": spot}
    if case.system.family == "cone_pendulum":
        return {**seen, "picture": centre_of_mass(case, seen["theta"], time)}
    if case.system.family == "free_body":
        return {**seen, "picture": corner_of_box(case, seen)}
    setup = case.problem.setup
    line = setup.heading + setup.direction
    if "displacement" in seen:
        place = seen["displacement"] * complex(math.cos(line), math.sin(line))
    else:
        place = complex(seen["x"], seen["y"])
        place *= complex(math.cos(setup.heading), math.sin(setup.heading))
    gone = place.real * math.cos(line) + place.imag * math.sin(line)
    return {
        "x": place.real,
        "y": place.imag,
        "heading": seen["heading"],
        "displacement": gone,
        "picture": (place.real, place.imag),
    }


def corner_of_box(case, seen):
    """Where the camera sees the corner of the free body's box: right and up, of its distance from
    the centre."""
    x, y, z = case.problem.inertia
    half = np.sqrt([y + z - x, x + z - y, x + y - z])
    turn = Rotation.from_quat([seen[f"attitude_{axis}"] for axis in "wxyz"], scalar_first=True)
    return seen_by_camera(*turn.apply(half / np.linalg.norm(half)))


def centre_of_mass(case, theta, time):
    """Where the camera sees the cone's centre of mass: right and up [m]."""
    problem, com = case.problem, case.problem.body.com_distance
    x, y = problem.pivot_x, problem.pivot_y + com * math.sin(theta)
    z, turn = problem.pivot_z - com * math.cos(theta), problem.platform_rate * time
    x, y = x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn)
    return seen_by_camera(x, y, z)


def seen_by_camera(x, y, z):
    """A place in the world as the camera sees it: right and up."""
    away = x * math.cos(AZIMUTH) + y * math.sin(AZIMUTH)
    right = y * math.cos(AZIMUTH) - x * math.sin(AZIMUTH)
    return right, z * math.cos(ELEVATION) - away * math.sin(ELEVATION)


def pytest_generate_tests(metafunc):
    """Every scene in the full profile; else one of each system, which is drawn as the others."""
    if metafunc.definition.name == "test_the_body_is_where_the_exact_answer_puts_it":
        full = metafunc.config.getoption("--profile") == "full"
        metafunc.parametrize("name", NAMES if full else ONE_OF_EACH)


@pytest.mark.long(keep=2)
def test_the_body_is_where_the_exact_answer_puts_it(name, page):
    assert misplaced(stopped(page, name), name) == []


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", ONE_OF_EACH)
def test_a_motion_shifted_by_a_hundredth_is_misplaced(name, shifted):
    assert misplaced(stopped(shifted, name), name) != []
