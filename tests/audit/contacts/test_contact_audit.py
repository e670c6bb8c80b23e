"""The contact audit on bodies that are not plumbob's: Coulomb's distances, the predicted errors."""

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model import rigid_piece, user_contacts
from plumbob.engines.audit import contacts
from plumbob.engines.audit.contacts import HEADINGS
from plumbob.reports.audit_from_python import audit_contacts
from plumbob.tests.audit.contacts.bodies_on_planes import (
    EXACT,
    FLAT,
    SPEED,
    audited_once,
    model_text,
    texts,
)
from plumbob.tests.audit.scenes_as_models import compiled

# The rest is of third order: 2 % of v dt/2 covers it at 2 ms, where tilts are largest.
REST = 0.02
DIAGONAL, ALONG = 0.25, 0.02  # relative errors of default contacts: at least, and at most
TURN = 3e-3  # relative: of a disc whose loads change by 5e-3 at most as it slides


def audited(text, **options):
    return audit_contacts(compiled(text), **options)


@pytest.fixture(name="found", scope="module", params=texts())
def _found(request):
    return audited_once(texts()[request.param])


@pytest.fixture(name="flat", scope="module")
def _flat():
    return audited_once(model_text(FLAT, 0.001))


@pytest.fixture
def two_steps(monkeypatch):
    """Audits at the model's own step and half of it, in a fifth of the time: for what does not
    depend on the number of steps. Their results are not those of `audited_once`."""
    monkeypatch.setattr(contacts, "HALVINGS", 1)


def missed(found):
    """The largest difference of measured and predicted errors, over v dt/2."""
    parts = []
    for one in found.pasted:
        predicted = found.predicted(one)
        parts.append(np.abs(found.errors(one) - predicted).max() / (SPEED * one.step / 2))
    return float(max(parts))


@pytest.mark.long(keep=1)
def test_pasted_contacts_miss_coulomb_by_what_is_predicted(found):
    assert found.exact == pytest.approx(EXACT, rel=1e-12)
    assert all(found.determined)
    assert len(found.pasted) == 4
    assert missed(found) < REST


@pytest.mark.long(keep=1)
def test_default_contacts_depend_on_the_direction(found):
    for one in found.own:
        errors = dict(zip(np.degrees(HEADINGS).round(), found.errors(one) / EXACT, strict=True))
        assert min(errors[angle] for angle in (45, 135, 225, 315)) > DIAGONAL
        assert abs(errors[0]) < ALONG
        assert found.dependence(one) > DIAGONAL
    assert found.dependence(found.pasted[0]) < 1e-3


@pytest.mark.long
def test_a_flat_body_on_three_points_turns_as_theory_says(flat):
    assert flat.exact_turn is not None
    turning = flat.pasted[-1].turning
    assert turning.turn == pytest.approx(flat.exact_turn, rel=TURN)
    own = flat.own[-1].turning
    assert own.turn != pytest.approx(flat.exact_turn, rel=10 * TURN)


@pytest.mark.long(keep=1)
def test_a_turn_on_more_points_is_said_to_be_open(found):
    assert found.exact_turn is None
    assert f"{len(found.standing.points)} points share the load" in found.why_turn


@pytest.mark.long
@pytest.mark.parametrize("factor", [0.97, 1.03])
def test_a_wrong_moment_of_inertia_is_seen(factor, flat, monkeypatch):
    right = rigid_piece._inertia
    monkeypatch.setattr(rigid_piece, "_inertia", lambda *given: factor * right(*given))
    spoilt = audited(model_text(FLAT, 0.001)).pasted[-1].turning
    assert spoilt.turn != pytest.approx(flat.exact_turn, rel=2 * TURN)


def softer(right):
    return lambda *given: {
        **(pair := right(*given)),
        "solref": 0.75 * np.asarray(pair["solref"]),
    }


def rougher(right):
    return lambda self: {foot: 1.001 * friction for foot, friction in right(self).items()}


@pytest.mark.usefixtures("two_steps")
@pytest.mark.parametrize(
    ("place", "name", "wrong", "body"),
    [
        (user_contacts, "own_pair", softer, "four-legged stand"),
        (user_contacts.MujocoContacts, "frictions", rougher, "four-footed box"),
    ],
)
def test_other_contacts_than_those_said_are_seen(place, name, wrong, body, monkeypatch):
    monkeypatch.setattr(place, name, wrong(getattr(place, name)))
    assert missed(audited(texts()[body])) > 2 * REST
