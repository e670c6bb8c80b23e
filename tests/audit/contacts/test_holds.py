"""What Coulomb's law says about bodies at rest, against closed forms that share no code with the
linear programme."""

import random

import mujoco
import pytest

from plumbob.engines.adapters.mujoco.own_model.held_bodies import held_bodies
from plumbob.engines.audit.holds import group_verdict
from plumbob.engines.own_motion import Start
from plumbob.tests.audit.contacts.held_arrangements import FRACTIONS, KINDS, Arrangement

SEED = 54
# Bisection knows the multiple of the friction to 2^-12, twice that above 1; cones are cut to 1e-4.
FRICTION = 6e-4
CUT = 1e-4  # relative error of a force by that of the cones, over the margin of friction
CLOSE = "too close to tell"


def drawn(number):
    """One of forty arrangements: each kind far below, just below, just above and far above its
    limit."""
    draw = random.Random(SEED + number)
    kind, fractions = KINDS[number // 4], FRACTIONS[number % 4]
    return kind(draw, draw.uniform(*fractions))


def judged(arrangement):
    """The verdict on the group of bodies at the start of an arrangement."""
    model = mujoco.MjModel.from_xml_string(arrangement.text)
    held = held_bodies(model, Start(arrangement.keyframe), None)
    (group,) = held.at_start.groups
    return group_verdict(group)


def missed(number):
    """Names what is wrong with the verdict on an arrangement; empty if nothing is."""
    arrangement = drawn(number)
    found = judged(arrangement)
    if found.coulomb == CLOSE:
        return CLOSE
    if found.coulomb != arrangement.coulomb:
        return f"{arrangement.name}: {found.coulomb}, not {arrangement.coulomb}"
    statics = found.statics
    if arrangement.friction is not None:
        assert statics.least_friction == pytest.approx(arrangement.friction, abs=FRICTION)
    if arrangement.force is not None:
        margin = 1.0 - (arrangement.friction or 0.0)
        assert statics.least_force == pytest.approx(arrangement.force, rel=CUT / margin)
    return ""


# One that slides, one that holds, and self-stress near its limit and without one
@pytest.mark.parametrize("number", [0, 3, 28, 33])
def test_an_arrangement_is_judged_as_its_closed_form_says(number):
    assert not missed(number)


# At the friction 1e6, the relative fall of slips is 1e-12: too slow to tell from settled ones.
@pytest.mark.parametrize(("friction", "said"), [(1.0, "holds"), (1e6, CLOSE), (1e10, CLOSE)])
def test_a_box_that_its_weight_presses_down_needs_no_preload(friction, said):
    pulled = Arrangement(
        name="box that is pulled sideways",
        text=f"""<mujoco><option gravity="3 0 -9.81"/><worldbody>
<geom type="plane" size="1 1 1" friction="{friction}"/><body pos="0 0 .1"><freejoint/>
<geom type="box" size=".1 .1 .1"/></body></worldbody></mujoco>""",
        coulomb="holds",
    )
    assert judged(pulled).coulomb == said


def test_a_ball_that_rests_on_planes_that_repeat_each_other_holds():
    planes = '<geom type="plane" size="1 1 1"/>' * 2
    ball = Arrangement(
        name="ball with a smaller ball inside",
        text=f"""<mujoco><worldbody>{planes}<geom type="box" size=".1 .1 .1"/><body pos="0 0 .1">
<freejoint/><geom size=".1"/><geom size=".05"/></body></worldbody></mujoco>""",
        coulomb="holds",
    )
    assert judged(ball).coulomb == "holds"


@pytest.mark.rare
def test_forty_arrangements_are_judged_as_their_closed_forms_say():
    answers = [missed(number) for number in range(4 * len(KINDS))]
    assert {answer for answer in answers if answer} <= {CLOSE}
    assert answers.count(CLOSE) <= 5
