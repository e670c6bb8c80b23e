"""The replays in a real browser: the canvas has the body where the exact answer puts it."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.replay.samples import encode_samples
from plumbob.tests.replay.all_replays import decoded, plan, replay_of, write
from plumbob.tests.replay.in_browser import FRACTION, opened, stopped

NAMES = [scene.name for scene in plan().scenes]
ONE_OF_EACH = (
    "bouncing-ball/half",
    "capsule-coast/spin",
    "capsule-hold/0.999",
    "capsule-line/heading-030",
    "capsule-plan/near-free",
    "capsule-train/ten",
    "capsule-turn/0.3",
    "cone-pendulum/rotating-base",
    "four-bar/crank-rocker",
    "free-body/flip",
    "heavy-top/nutating",
    "incline/stops",
    "linear-pendulum/overdamped",
    "n-pendulum/triple",
    "pinch/0.5",
    "projectile/thrown",
    "rod-impact/reverses",
    "rolling-ball/slide-to-roll",
    "servo/motor-damped",
    "simple-pendulum/free-small",
    "slider-crank/turning",
    "stack/equal",
)
RESTING = ("capsule-hold/0.999", "pinch/0.5", "stack/equal")
PIXEL = 0.5  # the centre of a disc of whole pixels is known to better than this
CENTRE = """(canvas, [rect, colour]) => {
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext("2d", {willReadFrequently: true});
  pen.drawImage(canvas, 0, 0);
  const [x0, y0, w, h] = rect.map(Math.round), seen = pen.getImageData(x0, y0, w, h).data;
  const found = [];
  for (let i = 0; i < w * h; i += 1) {
    if (seen[4 * i + 3] < 255 || colour.some((c, k) => Math.abs(seen[4 * i + k] - c) > 2)) continue;
    found.push([x0 + i % w + 0.5, y0 + Math.floor(i / w) + 0.5]);
  }
  // Edges that cross may have the colour, too: few pixels, which are left out.
  const median = (k) => found.map((p) => p[k]).sort((a, b) => a - b)[found.length >> 1];
  let centre = found.length ? [median(0), median(1)] : null;
  for (let times = 0; centre && times < 5; times += 1) {
    const near = found.filter((p) => Math.hypot(p[0] - centre[0], p[1] - centre[1]) < 7);
    centre = [0, 1].map((k) => near.reduce((sum, p) => sum + p[k], 0) / near.length);
  }
  return centre;
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
    """A replay whose exact motion is shifted by 1 % of the size of the picture, or of a radian."""
    data = json.loads(shown.data)
    layer = data["layers"][0]
    for channel in range(len(layer["channels"])):
        values = decoded(layer["channels"][channel], layer["count"])
        layer["channels"][channel] = encode_samples(values + 0.01 * max(data["size"], 1.0))
    return replace(shown, data=json.dumps(data))


def misplaced(figure, name):
    """Whether the mark is not where the exact answer puts it, within PIXEL."""
    case = case_of(find_scene(name))
    data = json.loads(replay_of(name).data)
    canvas = figure.locator(".live canvas")
    plan = json.loads(canvas.get_attribute("data-plan") or "")
    right, up, towards = np.array(data["camera"])
    assert np.cross(right, up) == pytest.approx(towards, abs=1e-5)
    place = marked(case, FRACTION * data["seconds"], *data["mark"])
    area = (0, 0, plan["width"], plan["height"])
    spot = plan["x"] + plan["scale"] * (right @ place), plan["y"] - plan["scale"] * (up @ place)
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


def marked(case, time, body, point):
    """The place [m] in the world of the marked point of a body at `time` [s], by the exact answer
    and the geometry of the system, and not by its model file."""
    seen = {n: float(v[0]) for n, v in case.reference.observe(np.array([time])).items()}
    return PLACES[case.system.family](case, seen, time, body, np.array(point))


def pendulum(case, seen, time, body, point):
    """The bob, or the link of a servo."""
    return Rotation.from_rotvec([0.0, -seen["theta"], 0.0]).apply(point)


def cone(case, seen, time, body, point):
    """The cone's centre of mass on the platform."""
    problem = case.problem
    com = problem.body.com_distance
    theta = seen["theta"]
    on_platform = (
        problem.pivot_x,
        problem.pivot_y + com * math.sin(theta),
        problem.pivot_z - com * math.cos(theta),
    )
    return Rotation.from_rotvec([0.0, 0.0, problem.platform_rate * time]).apply(on_platform)


def corner_of_box(case, seen, time, body, point):
    """A corner of the box with the body's moments of inertia, for the file's 6 kg."""
    x, y, z = case.problem.inertia
    half = np.sqrt(3.0 / 12.0 * np.array([y + z - x, x + z - y, x + y - z]))
    turn = Rotation.from_quat([seen[f"attitude_{axis}"] for axis in "wxyz"], scalar_first=True)
    return turn.apply(np.sign(point) * half)


def capsule(case, seen, time, body, point):
    """A point of the body, or of the slider."""
    setup = case.problem.setup
    if "displacement" in seen:
        spot = seen["displacement"] + 1j * seen["sideways"]
        spot *= np.exp(1j * (setup.heading + setup.direction))
    else:
        spot = complex(seen["x"], seen["y"]) * np.exp(1j * setup.heading)
    place = point[:2] @ [1.0, 1.0j]
    if body == 2:
        place += case.problem.motion.path.kinematics(np.array([time]))[0][0] @ [1.0, 1.0j]
    spot += place * np.exp(1j * seen["heading"])
    return np.array([spot.real, spot.imag, point[2]])


def rods(case, seen, time, body, point):
    """The centre of a rod of a chain that hangs from its axis."""
    lengths = case.problem.lengths
    directions = [
        np.array([math.sin(angle), 0.0, -math.cos(angle)])
        for angle in (seen[f"angle_{k}"] for k in range(1, len(lengths) + 1))
    ]
    parts = zip(lengths[: body - 1], directions, strict=False)
    above = sum((length * way for length, way in parts), np.zeros(3))
    return above + lengths[body - 1] / 2.0 * directions[body - 1]


def coupler(case, seen, time, body, point):
    """The middle of the coupler of a four-bar linkage, which is observed."""
    assert body == 2
    return np.array([seen["coupler_x"], 0.0, seen["coupler_y"]])


def rod(case, seen, time, body, point):
    """The middle of the rod between the crank's end and the slider."""
    assert body == 2
    across, up = case.problem.crank * np.array(
        [math.cos(seen["angle"]), math.sin(seen["angle"])]
    )
    return np.array([across + seen["slider"], 0.0, up]) / 2.0


def top(case, seen, time, body, point):
    """A point of a top's axis: tilted, then turned about the vertical."""
    turn = Rotation.from_euler("ZX", [seen["precession"], seen["tilt"]])
    return turn.apply([0.0, 0.0, point[2]])


PLACES = {
    "simple_pendulum": pendulum,
    "servo": pendulum,
    "cone_pendulum": cone,
    "free_body": corner_of_box,
    "capsule": capsule,
    "n_pendulum": rods,
    "slider_crank": rod,
    "four_bar": coupler,
    "heavy_top": top,
    "bouncing_ball": lambda case, seen, time, body, point: np.array(
        [0.0, 0.0, seen["z"] + 0.1]
    ),
    "projectile": lambda case, seen, *_: np.array([seen["x"], 0.0, seen["z"]]),
    "rod_impact": lambda case, seen, *_: np.array([seen["x"], 0.0, seen["z"]]),
    "rolling_ball": lambda case, seen, *_: np.array([seen["x"], 0.0, case.problem.radius]),
    "incline": lambda case, seen, *_: np.array([seen["x"], 0.0, 0.05]),
    "pinch": lambda *_: np.zeros(3),
    "stack": lambda case, seen, time, body, point: np.array([0.0, 0.0, 0.2 * body - 0.1]),
}


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
@pytest.mark.parametrize("name", [name for name in ONE_OF_EACH if name not in RESTING])
def test_a_motion_shifted_by_a_hundredth_is_misplaced(name, shifted):
    assert misplaced(stopped(shifted, name), name)
