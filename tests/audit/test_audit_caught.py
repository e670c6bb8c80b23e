"""Small defects of a reference are caught, not certified; what spoils an order is shown."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model import model as own_model_module
from plumbob.engines.adapters.mujoco.own_model.field import ContinuousField, without_step
from plumbob.engines.adapters.mujoco.own_model.model import MujocoModel, own_model
from plumbob.engines.audit import reference as reference_module
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.reference import certified
from plumbob.engines.audit.step_errors import last_tending_period
from plumbob.engines.own_motion import NotCertifiable
from plumbob.tests.audit.scenes_as_models import (
    audit_of,
    ball,
    pendulum,
    recast,
)

BUDGET = 60.0  # [s], far more than these take


@pytest.mark.long
def test_tolerance_that_is_spoilt_is_caught(monkeypatch):
    sound = audit_of(pendulum(), duration=0.4, period=0.4)
    assert sound.until == pytest.approx(0.4)
    assert sound.uncertainty < 1e-6
    assert sound.found.order.slope == pytest.approx(1.0, abs=0.01)
    monkeypatch.setattr(reference_module, "TIGHT", 1e-3)
    found = audit_of(pendulum(), duration=0.4, period=0.4)
    assert found.uncertainty > 100 * sound.uncertainty
    truth = abs(sound.reference.corners - found.reference.corners).max()
    assert truth <= sound.uncertainty + found.uncertainty  # what is claimed is so nevertheless


@dataclass(frozen=True)
class Layered(MujocoModel):
    """A model for which the smooth methods give up."""

    def field(self, width=0.0):
        if width:
            return super().field(width)
        return GivesUp(without_step(self.effective.__copy__()), self.start)


class GivesUp(ContinuousField):
    """A field that is not smooth enough."""

    def __call__(self, t, y):
        raise NotCertifiable("contacts chatter")


def test_layer_that_is_too_wide_is_caught(monkeypatch):
    """A ball on a layer of 1 cm is deeper than one on contacts that begin at once."""
    sound = certified_in_layers(monkeypatch, reference_module.WIDTHS)
    wide = certified_in_layers(monkeypatch, (3e-2, 1e-2))
    assert sound.uncertainty[-1] < 1e-4
    assert wide.uncertainty[-1] > 1e-3


def certified_in_layers(monkeypatch, widths):
    monkeypatch.setattr(reference_module, "WIDTHS", widths)
    own = recast(Layered, own_model(ball(0.13), "ball"))
    found = certified(own, script(own, duration=0.2), Allowance(BUDGET))
    assert found.widths == widths
    return found


@dataclass(frozen=True)
class Unclamped(MujocoModel):
    """A model whose reference has contacts as the file says, its steps as refsafe makes them."""

    raw: Any = None

    def field(self, width=0.0):
        model = without_step(self.raw.__copy__())
        return ContinuousField(model, self._new_data(model), width)


@pytest.mark.long
def test_clamp_that_is_left_out_is_caught():
    """Contacts of 0.1 ms at steps of 1 ms are raised to 2 ms: without that, the reference is that
    of another model, to which no step tends."""
    model = ball(0.12, solref=".0001 .3")  # it bounces
    sound = own_model(model, "ball")
    assert sound.clamped == {"geom_solref": 2}
    right = audit_of(model, duration=0.1)
    assert right.until == pytest.approx(0.1)
    raw = model.__copy__()
    raw.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    found = audit_of(recast(Unclamped, sound, raw=raw), duration=0.1)
    assert found.until < 0.07  # it falls onto the plane at 0.064 s
    with pytest.raises(AssertionError, match="no reference beyond"):
        found.assert_within(1.0)


def test_effective_contacts_are_those_that_refsafe_leaves():
    clamped, changed = own_model_module.clamped_model(ball(solref=".001 1"), 0.001)
    assert changed == {"geom_solref": 2}
    assert clamped.geom_solref[:, 0].tolist() == [0.002, 0.002]
    unchanged, nothing = own_model_module.clamped_model(ball(solref=".002 1"), 0.001)
    assert nothing == {}
    assert unchanged.geom_solref[:, 0].tolist() == [0.002, 0.002]


@pytest.mark.parametrize(("level", "until"), [(3e-6, 0), (0.9e-6, 1)])
def test_steps_that_level_off_above_what_is_known_do_not_tend(level, until):
    errors = (1e-3, level, level, level)
    steps = [
        SimpleNamespace(integrator="euler", parts=2**k, errors=np.array([0.0, error]))
        for k, error in enumerate(errors)
    ]
    known = SimpleNamespace(uncertainty=np.array([0.0, 1e-6]))
    assert last_tending_period(steps, steps[0], known) == until


def test_a_step_that_passes_over_a_contact_as_the_reference_does_is_no_confirmation():
    """Large steps stay with the reference, the finest ones touch; RK4 was as near as the reference
    is known, and had no finer run."""
    errors = {"euler": (1e-12, 1e-12, 1e-12, 0.2, 0.3), "rk4": (1e-12, 1e-12, 1e-12)}
    steps = [
        SimpleNamespace(integrator=name, parts=2**k, errors=np.array([0.0, error]))
        for name, sizes in errors.items()
        for k, error in enumerate(sizes)
    ]
    known = SimpleNamespace(uncertainty=np.array([0.0, 1e-12]))
    assert last_tending_period(steps, steps[0], known) == 0
