"""Energies on the platform against MuJoCo's own at any state, and the work of the drive."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plumbob.analytic.systems.cone_pendulum import ConePendulum, solid_cone
from plumbob.analytic.systems.platform_energy import drive_torque, energies
from plumbob.engines.adapters.mujoco.translation import filled
from plumbob.models.cone_pendulum.model import MODEL
from plumbob.tests.support.cone_scene import MJCF

STEEL = solid_cone(8000.0, 0.3, math.radians(30.0))
TURNING = ConePendulum(STEEL, 0.0, 0.09, 26.0, 9.8, 0.0, 37.0)
SKEW = replace(
    TURNING,
    body=replace(STEEL, inertia_y=STEEL.inertia_y + 0.01, inertia_yz=0.015),
    pivot_x=0.31,
    pivot_y=-0.2,
    pivot_z=0.7,
)
TIMES = np.linspace(0.0, 0.7, 401)


@pytest.mark.parametrize("pendulum", [TURNING, SKEW])
def test_kinetic_and_potential_energy_are_mujoco_s(pendulum):
    spec = filled(MJCF, MODEL, pendulum)
    spec.joint("platform").armature = 1e-9
    model = spec.compile()
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    own = (1.0 + 1e-9) * pendulum.platform_rate**2 / 2  # the platform's in the file
    for theta, rate in rng.uniform(-6.0, 6.0, (20, 2)):
        data.qpos[:] = [0.4, theta]
        data.qvel[:] = [pendulum.platform_rate, rate]
        mujoco.mj_forward(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        found = energies(pendulum, np.array([theta]), np.array([rate]))
        scale = data.energy[1] + abs(data.energy[0])
        assert abs(found.kinetic[0] + own - data.energy[1]) <= 1e-14 * scale
        assert abs(found.gravity[0] - data.energy[0]) <= 1e-14 * scale


@pytest.mark.parametrize("pendulum", [TURNING, SKEW])
def test_t_plus_u_less_the_work_of_the_drive_is_constant(pendulum):
    found = energies(pendulum, *pendulum.reference.state(TIMES))
    swing = float(np.ptp(found.total))
    assert swing > 100.0
    assert found.work[0] == 0.0
    assert float(np.ptp(found.total - found.work)) <= 1e-12 * swing
    # the work of a drive that is 1e-9 faster does not fit
    assert float(np.ptp(found.total - found.work * (1 + 1e-9))) > 1e-10 * swing


def test_the_parts_are_those_of_the_source():
    """Eqs. 3 to 5, written out for one state."""
    found = energies(SKEW, np.array([0.3]), np.array([2.0]))
    m = STEEL.mass
    s = STEEL.com_distance
    w = 26.0
    x = 0.31
    y = -0.2
    assert found.translation[0] == pytest.approx(m * w**2 * (x**2 + y**2) / 2)
    coupling = m * (y * s * w**2 * math.sin(0.3) + x * s * 2.0 * w * math.cos(0.3))
    assert found.coupling[0] == pytest.approx(coupling)
    y_rate = w * math.sin(0.3)
    z_rate = w * math.cos(0.3)
    turning = STEEL.inertia_x * 4.0 + (STEEL.inertia_y + 0.01) * y_rate**2
    turning += STEEL.inertia_z * z_rate**2 + 2 * 0.015 * y_rate * z_rate
    assert found.rotation[0] == pytest.approx(turning / 2)


@pytest.mark.parametrize("pendulum", [TURNING, SKEW])
def test_the_torque_of_the_drive_is_the_rate_of_the_angular_momentum(pendulum):
    # [s]: the next term of the difference is h^4/30 times a fifth derivative, 1e-9 here
    h = 1e-4
    torque = drive_torque(pendulum, *pendulum.reference.state(TIMES[1:-1]))
    one, two, four, five = (
        energies(pendulum, *pendulum.reference.state(TIMES[1:-1] + k * h)).angular_momentum
        for k in (-2, -1, 1, 2)
    )
    rate = (one - 8 * two + 8 * four - five) / (12 * h)
    largest = float(np.abs(torque).max())
    assert np.abs(torque - rate).max() <= 1e-6 * largest
    slower = drive_torque(
        replace(pendulum, platform_rate=26.0 * (1 - 1e-5)),
        *pendulum.reference.state(TIMES[1:-1]),
    )
    assert np.abs(slower - rate).max() > 3e-6 * largest
