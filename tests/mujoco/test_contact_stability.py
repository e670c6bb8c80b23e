"""The largest step at which bodies hold on soft contacts: predicted, and by nudged runs of MuJoCo.

Contacts as `plumbob settings` writes them, for 1 ms, are kept while the step grows. A body at rest
on them is nudged, and the step between a nudge that dies and one that grows is found by bisection.
"""

import math
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob.analytic.errors.contact_models.contact_stability import (
    ContactSpring,
    largest_contact_step,
)
from plumbob.analytic.errors.stability.largest_step import largest_step
from plumbob.analytic.schemes import EULER, RK4, Scheme
from plumbob.engines.adapters.mujoco.contacts import DAMPING, IMPEDANCE, STIFFNESS
from plumbob.engines.adapters.mujoco.file_check import frequency_ratio
from plumbob.engines.adapters.mujoco.settings_to_paste import OWN_STIFFNESS, rewritten
from plumbob.tests.mujoco.test_settings import own_model, snippets

WRITTEN = 1e-3  # [s]
WITHIN = 0.03  # of a limit, from both sides
NUDGE = 1e-6  # [m/s] up, and ten times as many rad/s: 1e-9 m and less in a step
LOST = 1e2  # of the nudge
STEPS = 3000
HEIGHT = 0.04  # [m] of the box on its feet
EXPLICIT = Scheme(EULER)  # in the damping of contacts, whatever a joint's is
INTEGRATORS = {"euler": EXPLICIT, "implicitfast": EXPLICIT, "rk4": Scheme(RK4)}
CAPSULE = Path(__file__).parents[2] / "models" / "tripod_capsule" / "tripod_capsule.xml"
BOX, STAND = "four-footed box", "four-legged stand"


def contact_spring(frequency, damping_ratio, impedance):
    """A contact along its normal that has this natural `frequency` [rad/s] on a lone body, but for
    a fraction `impedance` (MuJoCo's direct `solref`)."""
    regularisation = (1.0 - impedance) / impedance
    pull = frequency**2 / impedance
    drag = 2.0 * damping_ratio * frequency / impedance
    return ContactSpring(pull, drag, regularisation)


def safe_spring(time_constant, damping_ratio, impedance, step=0.0):
    """The same by a `time_constant` [s] (MuJoCo's `solref` of two positive numbers), which
    `refsafe` raises to two of `step` [s]; 0 where it is switched off."""
    tau = max(time_constant, 2.0 * step)
    stiffness = 1.0 / (impedance * (tau * damping_ratio) ** 2)
    return ContactSpring(stiffness, 2.0 / (impedance * tau), (1.0 - impedance) / impedance)


@cache
def model(body, integrator, dimensions):
    """A body on contacts for 1 ms, with friction (3 dimensions) or without (1), and a warning where
    it diverges in place of a reset."""
    if body == "capsule":
        spec = mujoco.MjSpec.from_string(rewritten(CAPSULE.read_text(), WRITTEN))
        spec.option.integrator = getattr(
            mujoco.mjtIntegrator,
            f"mjINT_{integrator.upper() if integrator == 'rk4' else 'EULER'}",
        )
        for pair in spec.pairs:
            pair.condim = dimensions
        compiled = spec.compile()
    else:
        mjcf = snippets(f"mujoco/{integrator}+coulomb", WRITTEN)[0].mjcf
        compiled = own_model(body, mjcf.replace('condim="3"', f'condim="{dimensions}"'))
    compiled.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    return compiled


def settled(body, step):
    """Coordinates at rest, found at a `step` [s] that is stable."""
    body.opt.timestep = step
    data = mujoco.MjData(body)
    if body.nkey:
        mujoco.mj_resetDataKeyframe(body, data, 0)
    mujoco.mj_step(body, data, nstep=round(3.0 / step))
    return np.array(data.qpos)


def holds(body, rest, step):
    """Whether a nudge of the body at rest stays small."""
    body.opt.timestep = step
    data = mujoco.MjData(body)
    data.qpos[:] = rest
    data.qvel[2:5] += NUDGE, 10 * NUDGE, 7 * NUDGE
    for _ in range(STEPS // 20):  # one that is lost may have come to rest elsewhere at the end
        mujoco.mj_step(body, data, nstep=20)
        if not np.abs(data.qvel).max() < LOST * NUDGE:
            return False
    return True


def measured(body, rest, below):
    """The largest step that holds [s], by bisection to 1 %, from half of `below` to twice it."""
    holding = below / 2
    lost = 2 * below
    assert holds(body, rest, holding)
    assert not holds(body, rest, lost)
    while lost / holding > 1.01:
        middle = math.sqrt(holding * lost)
        if holds(body, rest, middle):
            holding = middle
        else:
            lost = middle
    return math.sqrt(holding * lost)


def predicted_sliding(body, compiled, scheme):
    """Of the fastest mode alone, on contacts that only press."""
    frequency = (STIFFNESS if body == "capsule" else OWN_STIFFNESS) / WRITTEN
    contact = contact_spring(frequency, DAMPING, IMPEDANCE)
    return largest_contact_step(frequency_ratio(compiled), contact, scheme)


def predicted_at_rest(compiled, rest, scheme):
    """Of all directions of all contacts at once, friction holding, by the engine's own Jacobian."""
    data = mujoco.MjData(compiled)
    data.qpos[:] = rest
    mujoco.mj_forward(compiled, data)
    jacobian = data.efc_J.reshape(data.nefc, compiled.nv)
    solved = np.zeros_like(jacobian)
    mujoco.mj_solveM(compiled, data, solved, jacobian)
    normal = np.isin(np.arange(data.nefc), data.contact.efc_address)
    stiffness = np.where(normal, data.efc_KBIP[:, 0] * data.efc_KBIP[:, 2], 0.0)
    effect = jacobian @ solved.T
    answer = effect @ np.linalg.pinv(effect + np.diag(data.efc_R))
    nothing = np.zeros_like(answer)
    one = np.eye(len(answer))
    drift = np.block([[nothing, one], [nothing, nothing]])
    kick = np.block([[nothing, nothing], [-answer * stiffness, -answer * data.efc_KBIP[:, 1]]])
    one = np.eye(len(kick))

    def matrices(steps):
        h = steps[:, None, None]
        if scheme.integrator != RK4:
            return (one + h * drift) @ (one + h * kick)
        z = h * (drift + kick)
        return one + z @ (one + z @ (one / 2 + z @ (one / 6 + z / 24)))

    return largest_step(matrices, np.linalg.eigvals(drift + kick).astype(complex))


@pytest.mark.long(keep=4)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("body", ["capsule", BOX, STAND])
def test_contacts_hold_up_to_the_predicted_step(body, integrator):
    """Without friction, as in a slide: r (W^2 + 1.2 W) = 4 for semi-implicit Euler."""
    compiled = model(body, integrator, 1)
    scheme = INTEGRATORS[integrator]
    limit = predicted_sliding(body, compiled, scheme)
    rest = settled(compiled, limit / 5)
    assert measured(compiled, rest, limit) == pytest.approx(limit, rel=WITHIN)


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("body", [BOX, STAND])
def test_at_rest_friction_steadies_feet_and_has_a_limit_of_its_own(body, integrator):
    """Feet that stick allow a larger step, until friction that stops a slip within a step of 1 ms
    takes more than the slip away: from 2 ms with Euler, from 2.785/2 ms with RK4."""
    compiled = model(body, integrator, 3)
    scheme = INTEGRATORS[integrator]
    rest = settled(compiled, 2.5e-4)
    limit = predicted_at_rest(compiled, rest, scheme)
    assert measured(compiled, rest, limit) == pytest.approx(limit, rel=WITHIN)
    friction = 1.3926 * WRITTEN if integrator == "rk4" else 2 * WRITTEN
    assert limit <= friction * (1 + 1e-3)
    if body == STAND or integrator == "rk4":
        assert limit == pytest.approx(friction, rel=1e-3)
    assert abs(limit / predicted_sliding(body, compiled, scheme) - 1) > WITHIN


@cache
def guarded(solref, impedance, safe):
    """The box on contacts of a time constant, with or without `refsafe`, without friction."""
    flag = "enable" if safe else "disable"
    mjcf = (
        f'<option cone="elliptic"><flag refsafe="{flag}"/></option>'
        f'<default><pair condim="1" solref="{solref}" solimp="{impedance} {impedance} 1e-3"/>'
        '</default><contact><pair geom1="floor" geom2="foot_1"/></contact>'
    )
    compiled = own_model(BOX, mjcf)
    compiled.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    return compiled


@pytest.mark.parametrize("safe", [True, False])
@pytest.mark.parametrize(
    ("damping_ratio", "impedance"), [(1.0, 0.95), (0.3, 0.95), (1.0, 1e-4)]
)
def test_refsafe_holds_stiff_well_damped_contacts_at_any_step(damping_ratio, impedance, safe):
    """And no others: a damping ratio below 8^(-1/2), or an impedance that lets modes be faster than
    one contact, is lost with it as without. It never touches the direct form."""
    compiled = guarded(f"0.02 {damping_ratio}", impedance, safe)
    ratio = frequency_ratio(compiled)
    spring = safe_spring(0.02, damping_ratio, impedance)
    unguarded = largest_contact_step(ratio, spring, Scheme(EULER))
    rest = settled(compiled, 1e-4)  # with a larger step it falls further in one than it is deep
    depth = HEIGHT - rest[2]
    for step in (0.97 * unguarded, 1.03 * unguarded, 0.012, 0.024, 0.1):
        spring = safe_spring(0.02, damping_ratio, impedance, step if safe else 0.0)
        deeper = max(1.0, 2 * step / 0.02) ** 2 if safe else 1.0
        rest[2] = HEIGHT - depth * deeper
        expected = largest_contact_step(ratio, spring, Scheme(EULER)) > step
        assert holds(compiled, rest, step) == expected, step


def wrong_limits():
    """Limits of the box with a mistake in each."""
    ratio = frequency_ratio(model(BOX, "euler", 1))
    frequency = OWN_STIFFNESS / WRITTEN
    right = contact_spring(frequency, DAMPING, IMPEDANCE)

    def limit(ratio, contact, scheme=EXPLICIT):
        return largest_contact_step(ratio, contact, scheme)

    return {
        "one contact's frequency": limit(1.0, right),
        "a ratio of 1.1": limit(1.1 * ratio, right),
        "a factor of 1.0 for 1.2": limit(ratio, contact_spring(frequency, 0.25, IMPEDANCE)),
        "undamped": limit(ratio, contact_spring(frequency, 0.0, IMPEDANCE)),
        "damping implicit": limit(ratio, right, Scheme(EULER, implicit_damping=True)),
        "RK4": limit(ratio, right, Scheme(RK4)),
        "an impedance of 0.1": limit(ratio, contact_spring(frequency, DAMPING, 0.1)),
    }


@pytest.mark.parametrize("mistake", wrong_limits())
def test_a_mistake_in_the_condition_is_noticed(mistake):
    compiled = model(BOX, "euler", 1)
    rest = settled(compiled, 2.5e-4)
    wrong = wrong_limits()[mistake]
    sides = [holds(compiled, rest, side * wrong) for side in (1 - WITHIN, 1 + WITHIN)]
    assert sides != [True, False]
