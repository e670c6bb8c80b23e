"""What a plane of pymunk cannot have is refused, and named."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.adapters.pymunk.stepper import planar_stepper
from plumbob.engines.mechanism import NotExpressed
from plumbob.engines.method import Unsupported
from plumbob.engines.stepper import State
from plumbob.tests.support.planar import TIGHT, scene_mechanism


def refused(mechanism, start):
    """The reason for which a mechanism is refused."""
    with pytest.raises(Unsupported) as raised:
        planar_stepper(mechanism, start, TIGHT, 1e-3)
    return str(raised.value)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("free-body/flip", "pymunk has no free joint"),
        ("heavy-top/nutating", "pymunk moves in a plane"),
        ("rolling-disc/circle", "pymunk moves in a plane"),
        ("rolling-ball/to-rest", "pymunk has no rolling friction"),
    ],
)
def test_systems_of_space_are_refused(name, why):
    found = scene_mechanism(name)
    assert why in refused(found.mechanism, found.start)


def first_joint(**changes):
    return lambda m: replace(m, joints=(replace(m.joints[0], **changes), *m.joints[1:]))


def last_shape(**changes):
    return lambda m: replace(m, shapes=(*m.shapes[:-1], replace(m.shapes[-1], **changes)))


def first_touch(**changes):
    return lambda m: replace(m, touching=(replace(m.touching[0], **changes), *m.touching[1:]))


def pushed_across(mechanism):
    """A cube whose gravity has a part across the slope's fall and its speed."""
    return replace(mechanism, gravity=np.array([0.0, 3.0, -9.0]))


@pytest.mark.parametrize(
    ("name", "change", "why"),
    [
        ("n-pendulum/triple", first_joint(limits=(0.0, 1.0)), "no limits of joint hinge_1"),
        (
            "n-pendulum/triple",
            first_joint(friction_loss=np.ones(1)),
            "no friction of joint hinge_1",
        ),
        ("n-pendulum/triple", first_joint(armature=np.ones(1)), "no inertia of a joint"),
        (
            "n-pendulum/triple",
            first_joint(force_range=(0.0, 1.0)),
            "no range of forces of joint",
        ),
        ("n-pendulum/triple", first_joint(axis=np.array([0.0, 0.8, 0.6])), "turns out of it"),
        ("n-pendulum/triple", first_joint(kind="ball"), "no ball joint hinge_1"),
        ("stack/equal", first_joint(stiffness=1.0), "no spring along slide z_0"),
        ("stack/equal", first_joint(armature=np.ones(1)), "no inertia of slide z_0"),
        ("stack/equal", first_joint(body=2), "no weld: cube_0"),
        ("stack/equal", last_shape(kind="capsule"), "no capsule that touches: cube_4"),
        ("stack/equal", first_touch(sliding=(0.1, 0.2)), "depends on the direction"),
        (
            "pinch/0.5",
            last_shape(place=np.array([0.01, 0.0, 0.0])),
            "no shapes beside one another: left, right",
        ),
        ("incline/stops", pushed_across, "cube is pushed out of it"),
        (
            "simple-pendulum/free-large",
            first_joint(stiffness=1.0),
            "no spring that turns a point",
        ),
        (
            "cone-pendulum/rotating-base",
            first_joint(velocity=np.sin),
            "no platform that moves as",
        ),
        (
            "projectile/thrown",
            lambda m: replace(m, joints=m.joints[::-1]),
            "no hinge before another joint: body",
        ),
        (
            "four-bar/crank-rocker",
            lambda m: replace(m, loops=(replace(m.loops[0], kind="weld"),)),
            "no weld pin",
        ),
        (
            "stack/equal",
            lambda m: replace(m, not_expressed=(NotExpressed("tendon cord"),)),
            "no tendon cord",
        ),
        (
            "stack/equal",
            lambda m: replace(m, bodies=(*m.bodies[:-1], replace(m.bodies[-1], carried=0.5))),
            "no carried weight of cube_4",
        ),
    ],
)
def test_features_are_refused_by_name(name, change, why):
    found = scene_mechanism(name)
    assert why in refused(change(found.mechanism), found.start)


def test_a_start_out_of_the_plane_is_refused():
    found = scene_mechanism("incline/stops")
    start = State(found.start.qpos, found.start.qvel + np.array([0.0, 0.5, 0.0]))
    assert "cube is pushed out of it" in refused(found.mechanism, start)
