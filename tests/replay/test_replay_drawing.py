"""The drawing of a mechanism: bodies where MuJoCo has them, closed loops, a fitting view."""

import json
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.adapters.mujoco.solids import solids
from plumbob.engines.drawn_mechanism import DOWN, Solid, frames
from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.study.results import TaskResult
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.analyses.measurements import study_plan
from plumbob.reports.analyses.replay import replay, requests
from plumbob.reports.analyses.replay.picture import Picture
from plumbob.reports.records.page_records import records_of
from plumbob.reports.view.method_results import results_of
from plumbob.reports.view.site.views import scene_view
from plumbob.tests.replay.all_replays import decoded, plan, recorded, replay_of
from plumbob.tests.support.studies import SCENE, quick

# Joints of each kind, several in one body, anchors and references that are not zero.
EVERY_JOINT = """<mujoco><compiler angle="radian"/>
<worldbody><geom type="plane" size="1 1 1"/><geom type="box" size=".1 .1 .1" pos="2 0 0"/>
<body name="free" pos="0 0 1" quat="1 2 0 1"><freejoint/><geom type="box" size=".3 .2 .1"/>
  <body pos=".3 0 0" quat="1 0 1 0"><joint type="slide" axis="0 1 1" ref=".2"/>
    <joint axis="1 1 0" pos=".1 0 .2" ref=".7"/><geom type="capsule" size=".05 .2"/>
    <body pos="0 .1 .2"><joint type="ball" pos="0 0 .1"/><geom type="cylinder" size=".1 .05"/>
      <body pos=".1 0 0" euler="0 0 1"><geom type="ellipsoid" size=".1 .05 .02"/></body></body>
  </body></body>
<body pos="1 0 0"><joint axis="0 0 1"/><geom type="sphere" size=".1" pos=".2 0 0"/></body>
</worldbody></mujoco>"""
ROUNDING = 1e-12  # [m] of sums of a few products of numbers of size one


def test_bodies_are_where_mujoco_has_them():
    model = mujoco.MjModel.from_xml_string(EVERY_JOINT)
    drawn = own_model(model, "every joint").drawn
    random = np.random.default_rng(51)
    coordinates = random.normal(size=(5, model.nq))
    placed = frames(drawn, coordinates)
    data = mujoco.MjData(model)
    for k, qpos in enumerate(coordinates):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        for body in range(model.nbody):
            axes = placed.placed(body, np.eye(3))[k] - placed.places[body][k]
            assert placed.places[body][k] == pytest.approx(data.xpos[body], abs=ROUNDING)
            assert pytest.approx(data.xmat[body].reshape(3, 3), abs=ROUNDING) == axes.T


def test_each_geom_has_the_extent_that_mujoco_gives_it():
    """The bounding box of the thickened points is the one that the compiler has computed, within
    the distance of a polygon from its circle."""
    model = mujoco.MjModel.from_xml_string(EVERY_JOINT)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    shapes = list(solids(model, data))
    assert [shape.body for shape in shapes] == [0, 0, *range(1, model.nbody)]
    for geom, shape in enumerate(shapes):
        if shape.floor or not shape.body:
            continue
        places = (shape.points @ data.xmat[shape.body].reshape(3, 3).T) + data.xpos[shape.body]
        own = (places - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
        extent = np.abs(own).max(axis=0) + shape.radius
        polygon = 1.0 - np.cos(np.pi / 24.0)
        assert extent == pytest.approx(model.geom_aabb[geom, 3:], rel=polygon)


def test_every_scene_has_a_drawing():
    """Requested with the study, whatever its system."""
    drawn = {request.scene for request in requests(plan()) if hasattr(request, "samples")}
    assert drawn == {scene.name for scene in plan().scenes}


@pytest.mark.parametrize("name", ["four-bar/crank-rocker", "slider-crank/turning"])
def test_loops_stay_closed(name):
    """Loops of the exact motion are closed at all samples, and so are loops of runs whose errors
    are not magnified."""
    (request, *_) = requests(study_plan(recorded(name)))
    mechanism = recorded(name).extras[request].mechanism
    data = json.loads(replay_of(name).data)
    exact, *runs = data["layers"]
    coordinates = np.stack([decoded(c, exact["count"]) for c in exact["channels"]], axis=1)
    # Stored coordinates have 24 bits each.
    assert largest_gap(mechanism, coordinates) < 1e-6 * data["size"]
    samples = np.linspace(0.0, data["seconds"], exact["count"])
    for run in runs:
        times = decoded(run["times"], run["count"])
        changes = np.stack([decoded(c, run["count"]) for c in run["channels"]], axis=1)
        near = np.stack([np.interp(times, samples, row) for row in coordinates.T], axis=1)
        # Linear interpolation between 1601 samples leaves gaps, less than half a pixel of 440.
        assert largest_gap(mechanism, near + changes) < data["size"] / 880


def largest_gap(mechanism, coordinates):
    """The largest distance [m] of two points that a loop holds together."""
    placed = frames(mechanism, coordinates)
    gaps = [
        placed.placed(one, here[None]) - placed.placed(other, there[None])
        for (one, other), (here, there) in mechanism.loops
    ]
    assert gaps
    return float(np.linalg.norm(gaps, axis=-1).max())


VIEWS = {
    "bouncing-ball/half": "oblique",
    "capsule-line/heading-030": "oblique",
    "capsule-turn/0.3": "above",
    "cone-pendulum/rotating-base": "oblique",
    "free-body/flip": "oblique",
    "n-pendulum/triple": "plane",
    "projectile/thrown": "plane",
    "rolling-ball/slide-to-roll": "plane",
    "slider-crank/turning": "plane",
    "stack/equal": "oblique",
}


@pytest.mark.parametrize(("name", "view"), VIEWS.items())
def test_a_motion_is_seen_where_it_shows(name, view):
    shown = replay_of(name)
    assert shown.kind == view
    data = json.loads(shown.data)
    right, up, towards = np.array(data["camera"])
    assert [right @ up, up @ towards, right @ right, up @ up] == pytest.approx(
        [0.0, 0.0, 1.0, 1.0], abs=1e-5
    )
    picture = drawn_picture(name)
    seen = (picture.path @ np.array([right, up]).T).reshape(-1, 2)
    left, right_end, bottom, top = data["box"]
    assert (seen >= [left, bottom]).all()
    assert (seen <= [right_end, top]).all()
    # No more than four times as wide or as high as the motion and its floor need.
    assert np.hypot(*np.ptp(seen, axis=0)) > 0.25 * np.hypot(right_end - left, top - bottom)


def drawn_picture(name):
    """The picture of a scene's exact motion at the samples of its drawing."""
    (request, *_) = requests(study_plan(recorded(name)))
    drawing = recorded(name).extras[request]
    return Picture(drawing.mechanism, drawing.coordinates)


def test_what_is_far_from_a_motion_does_not_shrink_it():
    """A floor far below is cut off by the picture; one near it is not."""
    picture = drawn_picture("n-pendulum/triple")
    plane = np.eye(3)[[2, 0, 1]] * [1.0, 1.0, 0.0]

    def box(height):
        floor = Solid(0, plane - height * DOWN, 0.0, (0.5, 0.5, 0.5), floor=True)
        solids = (*picture.mechanism.solids, floor)
        mechanism = replace(picture.mechanism, solids=solids)
        return Picture(mechanism, picture.coordinates).box

    assert box(-100.0) == picture.box
    assert box(-1.5)[2] < -1.5


def test_a_slope_is_drawn_as_one():
    """The file of the incline has a level plane and an inclined gravity: up is against gravity."""
    _, up, _ = np.array(json.loads(replay_of("incline/stops").data)["camera"])
    slope = case_of(find_scene("incline/stops")).problem.slope
    downhill = np.array([1.0, 0.0, 0.0])
    assert downhill @ up < 0.0
    (request, *_) = requests(study_plan(recorded("incline/stops")))
    against = recorded("incline/stops").extras[request].mechanism.up
    assert downhill @ against == pytest.approx(-np.sin(slope))


def test_errors_count_the_turning_of_a_body():
    """A ball whose spin is wrong is displaced at its rim, though not at its centre."""
    picture = drawn_picture("rolling-ball/slide-to-roll")
    coordinates = np.zeros((1, 3))
    turned = picture.errors(coordinates, np.array([[0.0, 0.0, 0.01]]))
    assert turned == pytest.approx(2.0 * 0.1 * np.sin(0.005), rel=1e-9)


def test_a_motion_without_a_shape_has_no_replay():
    study = recorded(SCENE)
    (request, *_) = requests(study_plan(study))
    drawing = study.extras[request]
    without = replace(drawing, mechanism=replace(drawing.mechanism, solids=()))
    for extras in ({}, {**study.extras, request: without}):
        assert replay(replace(study, extras=extras), find_scene(SCENE)) is None


def test_a_drawing_is_stored_as_it_is():
    study = recorded("slider-crank/turning")
    (request, *_) = requests(study_plan(study))
    stored = TaskResult(study.extras[request], request)
    read = from_json(to_json(stored), TaskResult)
    assert read.request == request
    assert read.answer.coordinates.tobytes() == stored.answer.coordinates.tobytes()
    geometries = [
        Picture(result.answer.mechanism, result.answer.coordinates).geometry()
        for result in (stored, read)
    ]
    assert repr(geometries[0]) == repr(geometries[1])


@pytest.mark.rare
def test_an_older_replay_is_left_out():
    """A study that was stored with a picture that no script draws any more is shown without it."""
    study = quick()
    records = records_of(study)
    record = records.scenes[SCENE]
    results = [r for (name, _), r in results_of(study, records).items() if name == SCENE]
    shown = record.exact.replay
    assert scene_view(study, record, record.exact, results).replay == shown
    older = replace(record.exact, replay=replace(shown, kind="cone"))
    assert scene_view(study, record, older, results).replay is None
