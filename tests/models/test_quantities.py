"""Quantities of interest: what each scene is about, and the scale that its errors are held to."""

import math

import pytest

from plumbob.models.registry import case_of, matching_scenes, scene, systems


def about(chosen):
    case = case_of(chosen)
    return {q.observable: q for q in case.system.quantities(case)}


@pytest.mark.long(keep=6)
@pytest.mark.parametrize("chosen", matching_scenes(profile="quick"), ids=lambda s: s.name)
def test_every_scene_is_about_observables_of_its_own_with_scales(chosen):
    found = about(chosen)
    assert found
    names = {o.name for o in systems()[chosen.system].observables}
    assert set(found) <= names
    assert all(0.0 < q.scale < math.inf for q in found.values())


@pytest.mark.parametrize(
    ("name", "observable", "scale", "when"),
    [
        ("cone-pendulum/rotating-base", "theta", 1.0, "run"),  # a rotation: one radian
        ("cone-pendulum/pitchfork", "theta", 0.1, "run"),  # a libration: its amplitude
        ("simple-pendulum/free-large", "theta", math.radians(120), "run"),
        ("simple-pendulum/rotating-fast", "theta", 1.0, "run"),
        ("capsule-line/heading-045", "displacement", 5.5917e-3, "end"),  # its own final size
        ("capsule-hold/0.999", "displacement", 1e-3, "run"),  # ought to be none: declared
        ("capsule-coast/rotation", "heading", 0.52275, "end"),
        ("capsule-turn/thousand", "body_angle", 1.0, "end"),  # many turns: one radian
    ],
)
def test_scales_follow_from_the_motion(name, observable, scale, when):
    found = about(scene(name))[observable]
    assert found.scale == pytest.approx(scale, rel=2e-4)
    assert found.when == when


def test_a_turn_to_the_right_has_the_scale_of_one_to_the_left():
    left, right = (
        about(scene("capsule-coast/rotation", {"heading_rate": rate})) for rate in (6.0, -6.0)
    )
    assert right["heading"].scale == pytest.approx(left["heading"].scale, rel=1e-12)
