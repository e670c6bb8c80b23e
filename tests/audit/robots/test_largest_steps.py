"""Limits of the step of model files that dm_control and gymnasium distribute, beside what is known
of them: two in the quick profile, all of them in the full one."""

import tomllib
from pathlib import Path

import mujoco
import pytest

from plumbob.engines.adapters.mujoco.options import integrator_number
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified
from plumbob.engines.audit.stability import (
    ABOVE,
    BELOW,
    HELPS,
    AuditedMotion,
    find_remedies,
    limit_of_method,
)
from plumbob.tests.audit.robots.robot_files import folder

CASES = tomllib.loads(Path(__file__).with_name("known_steps.toml").read_text("utf-8"))
QUICK = ("fish", "inverted_pendulum")
AGAIN = 0.05  # of a limit: calibrated; the changed model's own motion is another by up to 13 mm


def compiled(package, name, integrator, request):
    """The file of a package, where it is installed and the profile has it."""
    if request.config.getoption("--profile") == "quick" and name not in QUICK:
        pytest.skip("in the full profile")
    if folder(package) is None:
        pytest.skip(f"{package} is not installed: pip install --no-deps {package}")
    model = mujoco.MjModel.from_xml_path(str(folder(package) / f"{name}.xml"))
    model.opt.integrator = integrator_number(integrator)
    return model


def limit_of(model, integrator):
    """A model along its certified motion, and its limit."""
    own = own_model(model, "model")
    moved = script(own, "rest")
    reference = certified(own, moved, Allowance(10.0))
    course = AuditedMotion(own, moved, reference.states)
    return course, limit_of_method(course, integrator)


@pytest.mark.parametrize(
    ("package", "name", "integrator", "holds", "fails", "first"), CASES["known"]
)
def test_a_limit_is_where_it_is_known_to_be(
    package, name, integrator, holds, fails, first, request
):
    course, limit = limit_of(compiled(package, name, integrator, request), integrator)
    # A cheetah at rest loses a nudge at 1.1 times its limit, and one that has moved does not yet.
    assert limit.confirmed or limit.holds_to < fails
    assert limit.largest_step == limit.predicted
    lost = [
        course.lost(integrator, side * limit.largest_step, limit.index)
        for side in (BELOW, ABOVE)
    ]
    assert lost == [False, True]
    assert holds < limit.largest_step < fails
    assert first in limit.first


@pytest.mark.parametrize(("package", "name", "integrator"), CASES["beyond"])
def test_a_limit_beyond_what_is_tried_is_said_as_that(package, name, integrator, request):
    _, limit = limit_of(compiled(package, name, integrator, request), integrator)
    assert (limit.largest_step, limit.confirmed) == (None, True)


@pytest.mark.parametrize(("package", "name", "integrator", "remedy"), CASES["remedies"])
def test_a_remedy_gives_what_is_claimed_of_it(package, name, integrator, remedy, request):
    """The file with the remedy's numbers written into it, as one would, and audited as a model of
    its own along its own certified motion."""
    changed = compiled(package, name, integrator, request)
    course, own = limit_of(compiled(package, name, integrator, request), integrator)
    claimed = next(r for r in find_remedies(course, [own]) if r.change.name == remedy)
    for field, places, value in claimed.change.sets:
        getattr(changed, field).reshape(-1)[list(places)] = value
    _, again = limit_of(changed, integrator)
    assert again.confirmed
    assert again.largest_step == pytest.approx(claimed.limit.largest_step, rel=AGAIN)
    assert again.reach > HELPS * own.reach
