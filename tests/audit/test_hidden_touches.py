"""Contacts that adaptive steps pass over are found: fast bodies, thin walls, rods that turn."""

import copy
import math
import time

import mujoco
import pytest

from plumbob.engines.adapters.mujoco.colliding_pairs import (
    colliding_pairs,
    unmeasured,
)
from plumbob.engines.adapters.mujoco.own_model import hidden_touches
from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified, integration
from plumbob.engines.own_motion import Start
from plumbob.reports.view.audit.page import answer_rows, audit_answer
from plumbob.reports.view.audit.records import record
from plumbob.tests.audit.fast_bodies import DURATION, audited, first_touch, scene
from plumbob.tests.audit.scenes_as_models import audit_of, compiled

BUDGET = 10.0  # [s]
# Of the first, the stages of a step's polynomial alone meet the wall, and spoil the polynomial.
CASES = (162, *range(39))
# A ball of 6 mm at 100 m/s and a card of 1 mm, between which no stage lies.
CARD = """
<mujoco model="card"><option timestep="0.002" gravity="0 0 0"/><worldbody>
  <geom name="card" type="box" size="0.0005 0.5 0.5" pos="{place} 0 {height}"/>
  <body><freejoint/><geom name="ball" size="0.003" mass="2e-4" margin="{margin}"/></body>
  </worldbody>
  <keyframe><key name="shot" qvel="100 0 0 0 0 0"/></keyframe></mujoco>
"""


def card(place=1.0317, height=0.0, margin=0.0):
    return CARD.format(place=place, height=height, margin=margin)


def course(text, method="RK45", tolerance=1e-8):
    own = own_model(compiled(text), "card", Start(0))
    return integration(own, script(own, duration=0.04), method, tolerance, BUDGET)


@pytest.mark.parametrize(("method", "tolerance"), [("RK45", 1e-8), ("DOP853", 1e-10)])
def test_a_card_between_two_steps_is_met_when_the_ball_is_there(method, tolerance):
    """The ball touches from its centre at 28.2 mm of the metre on, at 100 m/s."""
    found = course(card(), method, tolerance)
    assert not found.why
    begins = (1.0317 - 0.0005 - 0.003) / 100.0
    # A contact's first state: within a step of a few microseconds.
    assert found.events[0] == pytest.approx(begins, abs=5e-6)
    assert found.states[-1][7] < 99.9  # the card has slowed it


@pytest.mark.parametrize(
    ("text", "met"),
    [
        (card(height=0.5029999), True),  # by 0.1 µm
        (card(height=0.5030001), False),
        (card(height=0.504, margin=0.0011), True),
        (card(height=0.504, margin=0.0009), False),
    ],
)
def test_a_ball_that_just_passes_an_edge_meets_nothing(text, met):
    assert bool(course(text).events) == met


@pytest.mark.rare(keep=4)
@pytest.mark.long(keep=1)
@pytest.mark.parametrize("seed", CASES)
def test_no_certificate_passes_over_what_steps_of_a_microsecond_touch(seed):
    own, motion = audited(seed)
    found = certified(own, motion, Allowance(BUDGET))
    known = motion.times[found.known]
    touch = first_touch(scene(seed), DURATION)
    events = found.course.events
    if math.isinf(touch):
        assert not events
    elif touch < known:
        # Both know the beginning to a step or two of a microsecond.
        assert events[0] == pytest.approx(touch, abs=1e-5)


# A ball on a spring, which turns back at a wall.
SWING = """
<mujoco model="swing"><option gravity="0 0 0"/><worldbody>
  <geom type="box" size="0.01 0.1 0.1" pos="{wall} 0 0"/>
  <body><joint type="slide" axis="1 0 0" stiffness="{stiffness}"/>
    <geom size="0.01" mass="1"/></body></worldbody>
  <keyframe><key qvel="{rate}"/></keyframe></mujoco>
"""
RATE = 50.0  # [1/s]


def swing(wall):
    """It swings by 0.1 m, so that a wall whose face is at 0.11 m is just met."""
    return SWING.format(wall=wall + 0.01, stiffness=RATE**2, rate=0.1 * RATE)


@pytest.mark.parametrize(
    ("wall", "met"), [(0.10999, True), (0.11 - 1e-8, True), (0.11001, False)]
)
def test_a_wall_at_which_a_motion_turns_back_is_met(wall, met):
    """By 10 µm, or by 10 nm: the tolerance of 1e-10 is far below that."""
    assert bool(course(swing(wall), "DOP853", 1e-10).events) == met


@pytest.mark.parametrize(
    ("bound", "value", "text"),
    [
        ("PATH", 0.5, card()),
        ("CURVED", 0.0, swing(0.10999)),
        ("SHALLOW", 1e-7, swing(0.11 - 1e-8)),
    ],
)
def test_bounds_that_are_too_low_pass_over_a_contact(monkeypatch, bound, value, text):
    monkeypatch.setattr(hidden_touches, bound, value)
    assert not course(text, "DOP853", 1e-10).events


# The ball's surface is as high as the upper edge of the card.
GRAZING = card(height=0.503)


def test_a_ball_that_grazes_an_edge_within_rounding_meets_nothing():
    """If a touch of no depth counted, it would be met again and again."""
    found = course(GRAZING)
    assert not found.events
    assert not found.why


@pytest.mark.parametrize(("bound", "value"), [("LOOKS", 4), ("FAR", 1e-3)])
def test_bounds_that_are_too_small_refuse_a_motion_that_is_clear(monkeypatch, bound, value):
    """Too few states, and a distance that is not measured beyond a millimetre. The search ends
    after as many states as LOOKS says, of a fifth of a millisecond each."""
    monkeypatch.setattr(hidden_touches, bound, value)
    begun = time.process_time()
    assert "pass too close to tell whether they touch" in course(GRAZING).why
    assert time.process_time() - begun < 5.0  # [s]


# A rod that turns several times in a control period, at a constant rate: its angle is a line, and a
# step may be as long as the period. It meets a peg at each turn.
ROD = """
<mujoco model="rod"><option gravity="0 0 0"/><worldbody>
  <geom size="0.001" pos="-0.3 0.001 0" {peg}/>
  <body><joint axis="0 0 1"/><geom type="capsule" fromto="0 0 0 .31 0 0" size="0.002"/></body>
  </worldbody><keyframe><key qvel="900"/></keyframe></mujoco>
"""


@pytest.mark.parametrize(("peg", "met"), [("", True), ('contype="0" conaffinity="0"', False)])
def test_a_rod_meets_a_peg_that_it_passes_within_a_step(peg, met):
    assert bool(course(ROD.format(peg=peg)).events) == met


def test_bounds_that_hold_for_half_a_radian_let_steps_be_long(monkeypatch):
    """Two bodies in contact that turn: with a hundredth of that angle the audit takes three times
    as many steps, with a thousandth 27 times."""
    steps = []
    good = hidden_touches.HiddenTouches.within

    def counted(search, *given):
        steps.append(given)
        return good(search, *given)

    monkeypatch.setattr(hidden_touches.HiddenTouches, "within", counted)
    assert integration(*audited(3), "RK45", 1e-8, BUDGET).events
    assert len(steps) < 150  # 67


PAIRS = """
<mujoco model="pairs">
  <asset><hfield name="hill" nrow="2" ncol="2" size="1 1 .1 .1" elevation="0 0 0 0"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 .1"/> <geom name="step" type="box" size=".1 .1 .1"/>
    <body name="static" pos="1 0 0"><geom name="post" size=".1"/></body>
    <body name="mocap" mocap="true" pos="2 0 1"><geom name="hand" size=".1"/></body>
    <body name="base" pos="3 0 1"><freejoint/>
      <geom name="base" size=".1" margin=".02" gap=".01"/>
      <body name="fixed" pos="1 1 0"><geom name="fixed" size=".1"/>
        <body name="arm" pos="1 0 0"><joint/>
          <geom name="arm" type="ellipsoid" size=".1 .1 .1" margin=".01"/>
          <body name="hook" pos="1 1 1"><joint/>
            <geom name="hook" type="capsule" size=".1 .1"/></body></body></body>
      <body name="ghost" pos="0 0 3"><joint/>
        <geom name="ghost" size=".1" contype="0" conaffinity="2"/></body>
    </body>
    <body name="loose" pos="0 5 2"><freejoint/>
      <geom name="loose" type="cylinder" size=".1 .1" contype="2"/></body>
    {more}
  </worldbody>
  <contact><exclude body1="base" body2="hook"/>
    <pair geom1="ghost" geom2="hook" margin=".03"/>
    <pair geom1="arm" geom2="floor" gap=".1"/></contact>
</mujoco>
"""


@pytest.mark.parametrize(
    "flag", ['energy="disable"', 'filterparent="disable"', 'contact="disable"']
)
def test_pairs_and_margins_are_those_of_mujocos_collisions(flag):
    """With gaps that make them look a kilometre far."""
    text = PAIRS.format(more="").replace("<asset>", f"<option><flag {flag}/></option><asset>")
    model = compiled(text)
    pairs, margins = colliding_pairs(model)
    ours = {tuple(sorted(pair)): m for pair, m in zip(pairs.tolist(), margins, strict=True)}
    far = copy.copy(model)
    far.geom_gap[:], far.pair_gap[:] = 1e3, 2e3
    far.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MIDPHASE)  # it takes no gap
    data = mujoco.MjData(far)
    mujoco.mj_forward(far, data)
    theirs = {tuple(sorted(c.geom.tolist())): c.includemargin for c in data.contact}
    assert ours == pytest.approx(theirs)
    assert bool(ours) == ("contact" not in flag)


def test_what_cannot_be_measured_is_said():
    hill = '<geom type="hfield" hfield="hill"/>'
    passive = hill.replace("/>", ' contype="0" conaffinity="0"/>')
    kinds = [unmeasured(compiled(PAIRS.format(more=more))) for more in ("", hill, passive)]
    assert kinds == [(), ("height fields",), ()]
    audit = audit_of(compiled(PAIRS.format(more=hill)), duration=0.002, period=0.002)
    assert record(audit)["unchecked"] == ["height fields"]
    said = "not checked for contacts between two steps of the reference: height fields"
    assert said in dict(answer_rows(audit_answer(audit)))["model"]
