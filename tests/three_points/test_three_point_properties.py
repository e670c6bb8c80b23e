"""Properties of every three-point motion: Coulomb's law, balances, symmetries, error."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss

from plumbob.analytic.systems.slider_path import SliderPath, StraightPiece
from plumbob.analytic.systems.three_points.equations import cross
from plumbob.analytic.systems.three_points.forces import loading
from plumbob.analytic.systems.three_points.friction import Start, three_point_motion
from plumbob.analytic.systems.three_points.implicit_friction import load_factor
from plumbob.tests.support.plane_motions import loadings
from plumbob.tests.support.random_slides import ending, pose, slide

SEEDS = st.integers(0, 10**6)


def exchanged(load, weights):
    """What friction and actuator give over a segment: energy, momentum, angular momentum."""
    (force, torque) = load.friction
    power = (load.actuator.conjugate() * load.terms.velocity).real
    turn = np.exp(1j * load.states[:, 4])
    centre = load.states[:, 5:] @ [1.0, 1j] + load.body.mass_ratio * load.terms.position * turn
    resisted = (force.conjugate() * load.velocity).real + torque * load.states[:, 2]
    assert resisted.max() <= 1e-13 * np.abs(resisted).max() + 1e-300
    force = force * turn
    spans = weights * load.pace
    torque = torque + cross(centre, force)
    rates = np.column_stack([resisted + power, force.real, force.imag, torque])
    return np.stack([spans @ rates, spans @ np.abs(rates)])


def held(load):
    """Energy, momentum and angular momentum about the ground's origin at the first sample."""
    body = load.body
    at = load.terms
    omega = load.states[:, 2]
    turn = np.exp(1j * load.states[:, 4])
    centre = load.states[:, 5:] @ [1.0, 1j] + body.mass_ratio * at.position * turn
    carried = load.velocity + body.mass_ratio * at.velocity
    within = at.velocity + 1j * omega * at.position
    energy = body.mass * np.abs(carried) ** 2 + body.reduced_mass * np.abs(within) ** 2
    momentum = body.mass * carried * turn
    spin = at.inertia * omega
    spin = spin + body.reduced_mass * cross(at.position, at.velocity) + cross(centre, momentum)
    energy = 0.5 * (energy + body.body_inertia * omega**2)
    return np.column_stack([energy, momentum.real, momentum.imag, spin])[0]


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("seed", [2, 6, 24, 26, 27, 89, 120, 174])
def test_energy_and_momentum_balance(seed):
    """Gauss quadrature of 64 points per segment is accurate to 1e-12 of the total exchange."""
    motion = slide(seed).motion()
    (x, weights) = leggauss(64)
    segments = [segment for segment in motion.segments if np.isfinite(segment.end)]
    parts = [exchanged(loading(motion, s, 0.5 * (x + 1.0)), 0.5 * weights) for s in segments]
    flow, gross = np.sum(parts, axis=0)
    first = held(loading(motion, segments[0], np.zeros(1)))
    last = held(loading(motion, segments[-1], np.ones(1)))
    assert (np.abs(last - first - flow) <= 5e-12 * (gross + gross[1:3].max())).all()


@given(SEEDS)
@settings(max_examples=8)
def test_friction_obeys_coulomb_and_the_body_stops(seed):
    """What accelerates the body is among the wrenches that Coulomb's law allows."""
    case = slide(seed)
    motion = case.motion()
    assert np.isfinite(motion.rest_time)
    for load in loadings(motion, np.linspace(0.0, motion.rest_time, 40, endpoint=False)):
        for wrench in zip(load.terms.limits, load.terms.arms, *load.friction, strict=True):
            assert load_factor(*wrench)[0] <= 1.0 + 1e-9
    speeds = motion.at(motion.rest_time + np.array([0.0, 1.0]))
    assert not speeds.velocity.any()
    assert not speeds.angular_velocity.any()


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("seed", [0, 89, 27, 24])
def test_it_knows_its_own_error(seed):
    """The error against 36 nodes is within the error that the motion gives, and that is small."""
    case = slide(seed)
    motion = case.motion()
    better = three_point_motion(case.capsule, case.path, case.start, nodes=36, tolerance=1e-13)
    times = np.linspace(0.0, ending(motion), 50)
    own = motion.at(times)
    other = better.at(times)
    said = motion.error
    for name in ("position", "heading"):
        off = np.abs(getattr(own, name) - getattr(other, name)).max(axis=0)
        # A coarser motion may accidentally be more accurate than the fine one.
        assert (off <= 10.0 * getattr(said, name)[0] + 1e-15).all()
        assert getattr(said, name).max() <= 1e-11


def mirrored(piece):
    """A piece of a path in a mirror along x."""
    if isinstance(piece, StraightPiece):
        x, y = piece.origin
        return replace(piece, origin=(x, -y), direction=-piece.direction)
    turned = {name: -getattr(piece, name) for name in ("angle", "rate", "acceleration")}
    return replace(piece, **turned)


@given(SEEDS)
@settings(max_examples=10)
def test_a_mirror_does_the_same_to_the_motion(seed):
    case = slide(seed)
    body = replace(case.capsule, supports=tuple((x, -y) for x, y in case.capsule.supports))
    (vx, vy) = case.start.velocity
    omega = case.start.angular_velocity
    path = SliderPath(tuple(map(mirrored, case.path.pieces)))
    time = ending(case.motion())
    again = pose(three_point_motion(body, path, Start((vx, -vy), -omega)), time)
    np.testing.assert_allclose(
        again, pose(case.motion(), time) * [1, -1, -1], rtol=0, atol=1e-12
    )
