"""The replay of an audit: bodies where the certified motion has them, errors as they are."""

import json
import math
from contextlib import contextmanager
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from plumbob.reports.analyses.replay.geoms import ELEVATION, audited
from plumbob.reports.view.audit.page import answered, page
from plumbob.reports.view.notation import metres
from plumbob.tests.audit.scenes_as_models import audit_of
from plumbob.tests.replay.all_replays import decoded
from plumbob.tests.replay.in_browser import FRACTION, found, opened, set_time
from plumbob.tests.replay.test_replay_picture import misses

# A geom of each kind, on a body that turns and falls.
MODEL = """<mujoco><option timestep=".01"/>
<asset><mesh name="wedge" vertex="0 0 0 .1 0 0 0 .1 0 0 0 .1"/></asset>
<worldbody><geom type="plane" size="0 0 1" pos="0 0 -3"/>
<body name="arm"><joint axis="0 1 0"/>
  <geom type="capsule" size=".03" fromto="0 0 0 .5 0 0"/>
  <body name="wrist" pos=".5 0 0"><joint axis="0 1 .5"/>
    <geom type="box" size=".05 .03 .1"/><geom type="sphere" size=".05" pos=".1 0 0"/>
    <geom type="cylinder" size=".03 .05" pos=".2 0 0"/><geom type="mesh" mesh="wedge"/>
    <geom type="ellipsoid" size=".02 .03 .06" pos=".3 0 0"/></body></body></worldbody></mujoco>"""


@cache
def audit():
    """The audit of that model over half a second."""
    return audit_of(MODEL, duration=0.5)


@cache
def shown():
    """Its replay."""
    replay = audited(audit())
    assert replay is not None
    return replay


@pytest.fixture(scope="module", name="figures")
def _figures(browser, tmp_path_factory):
    """Its page, and one on which the certified motion is shifted by a hundredth of the picture."""
    data = json.loads(shown().data)
    key = f"{data['geometry']['worst']}x"
    data["layers"][0]["channels"][key]["low"] += 0.01 * data["size"]
    files = []
    for name, replay in (("page", shown()), ("shifted", replace(shown(), data=json.dumps(data)))):
        files.append(tmp_path_factory.mktemp(name) / "page.html")
        files[-1].write_text(page(answered(audit()), audit(), "", None, replay), "utf-8")
    look = contextmanager(opened)
    with look(browser, files[0]) as right, look(browser, files[1]) as wrong:
        yield [right, wrong]


def test_the_errors_are_those_of_the_audit():
    ghost = shown().layers[1]
    assert ghost.largest == metres(audit().error)
    data = json.loads(shown().data)
    exact, own = data["layers"]
    for k, name in enumerate(audit().model.bodies[1:], 1):
        end = [decoded(exact["channels"][f"{k}{axis}"], exact["count"])[-1] for axis in "xyz"]
        assert end == pytest.approx(audit().pose[name], abs=1e-4 * data["size"])
    apart = [decoded(own["channels"][f"2{axis}"], own["count"]) for axis in "xyz"]
    assert np.linalg.norm(apart, axis=0).max() == pytest.approx(audit().error, rel=1e-3)


@pytest.mark.long
def test_the_body_is_where_the_certified_motion_has_it(figures):
    for page_of, misplaced in zip(figures, (False, True), strict=True):
        figure = found(page_of, "model")
        figure.locator("[data-layer]").nth(1).uncheck()
        set_time(figure, FRACTION)
        assert (_apart(figure) > 0.0) == misplaced


def _apart(figure):
    """How far [pixel] the mark is from where the certified motion has the marked body."""
    canvas = figure.locator(".live canvas")
    plan = json.loads(canvas.get_attribute("data-plan") or "")["picture"]
    data = json.loads(shown().data)
    time, model = FRACTION * data["seconds"], audit().model
    states, _ = audit().states
    times = audit().script.times
    places = model.positions(states)[:, data["geometry"]["worst"]]
    x, y, z = (np.interp(time, times, places[:, k]) for k in range(3))
    across, up = x, z * math.cos(ELEVATION) + y * math.sin(ELEVATION)
    spot = plan["x"] + plan["scale"] * across, plan["y"] - plan["scale"] * up
    return misses(canvas, (0, 0, plan["width"], plan["height"]), spot)
