"""The replay of an audit: bodies where the certified motion has them, errors as they are."""

import json
from functools import cache

import numpy as np
import pytest

from plumbob.engines.drawn_mechanism import frames
from plumbob.reports.analyses.replay.audit_motion import audit_replay
from plumbob.reports.records.notation import metres
from plumbob.tests.audit.scenes_as_models import audit_of
from plumbob.tests.replay.all_replays import decoded

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
    replay = audit_replay(audit())
    assert replay is not None
    return replay


def test_the_errors_are_those_of_the_audit():
    ghost = shown().layers[1]
    assert ghost.largest == metres(audit().error)
    data = json.loads(shown().data)
    exact, own = data["layers"]
    model = audit().model
    ends = [decoded(channel, exact["count"])[-1] for channel in exact["channels"]]
    placed = frames(model.drawn, np.array([ends]))
    for body, drawn in enumerate(model.drawn.bodies[1:], 1):
        centre = placed.placed(body, drawn.centre[None])[0, 0]
        wanted = audit().pose[model.bodies[body]]
        assert centre == pytest.approx(wanted, abs=1e-4 * data["size"])
    apart = decoded(own["error"], own["count"])
    assert np.max(apart) == pytest.approx(audit().error, rel=1e-3)
