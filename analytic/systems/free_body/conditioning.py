"""Response of a free body's rotation to errors: of its inputs, of a rounding on the way, of a
scheme."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from plumbob.analytic.numerics.arithmetic import ULP, varied
from plumbob.analytic.numerics.quad import double, quad
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES, Rotation

# Of an input, for a difference quotient: of the distance from the separatrix, for the response to
# be linear, and more than the closed form's own rounding error of 1e-15 shows.
_CHANGE = 1e-4
_LEAST = 1e-14


def uncertainty(body: Rotation, times: Array) -> Mapping[str, Array]:
    """Change of each observable at `times` [s], shape (n,), for one unit in the last place of every
    input, of the times, and of the angular momentum where it is nearest to an axis: a start next to
    the unstable axis has small components, whose roundings are small, and later ones are not."""
    times = np.asarray(times, dtype=np.float64)
    here = body.state(times)
    fastest = double(body.magnitude / min(body.inertia))
    late = ULP * (1.0 + fastest * np.abs(times))
    moved_rates = ULP * np.abs(here[0]) + late * (fastest if body.turning else 0.0)
    moved = np.concatenate([moved_rates, np.full_like(here[1], ULP) + late])
    change = _change(body)
    for near in varied(body, change):
        moved = moved + np.abs(np.concatenate(near.state(times)) - np.concatenate(here)) * (
            ULP / change
        )
    if body.turning is not None:
        moved = moved + _rounded_on_the_way(body, times)
    return dict(zip((*RATES, *ATTITUDE), moved, strict=True))


def nonlinearity(body: Rotation, times: Array, errors: Mapping[str, Array]) -> float:
    """Nonlinearity of the response to errors of the observables, shape (n,) each: the largest of
    the error angle of the attitude, the change of the momentum over its magnitude, and that of its
    distance from the separatrix over the squares which make it up."""
    if not body.magnitude:
        return 0.0
    inertia = np.array([double(i) for i in body.inertia])[:, None]
    change = inertia * np.stack([errors[name] for name in RATES])
    angle = 2.0 * np.sqrt(sum(errors[name] ** 2 for name in ATTITUDE))
    part = np.sqrt((change**2).sum(axis=0)) / double(body.magnitude)
    largest = max(float(np.max(angle)), float(part.max()))
    if body.turning is None:
        return largest
    momentum = inertia * body.state(times)[0]
    # of the energy over the separatrix's, which has nothing from the middle axis
    weights = 1.0 / np.median(inertia) - 1.0 / inertia
    drift = (weights * momentum * change).sum(axis=0)
    size = (np.abs(weights) * momentum**2).sum(axis=0)
    return max(largest, float(np.max(2.0 * np.abs(drift) / size)))


def _change(body: Rotation) -> float:
    """Relative change of inputs whose response is linear."""
    if body.turning is None:
        return _CHANGE**2
    return max(_LEAST, _CHANGE**2 * float(double(body.turning.b / body.turning.a)) ** 2)


def _rounded_on_the_way(body: Rotation, times: Array) -> Array:
    """Change by a rounding of each component of the angular momentum, one unit in the last place of
    its magnitude, where the middle one first passes zero; shape (7, n)."""
    turning = body.turning
    assert turning is not None
    wait = -turning.begin
    if wait < 0.0 and math.isfinite(half := float(double(turning.half_turn))):
        wait += half
    x, y, z = map(quad, body.state(np.array([wait]))[0][:, 0])
    there = Rotation(body.inertia, (x, y, z))
    after = np.maximum(times - wait, 0.0)
    rates, attitude = there.state(after)
    change = _change(body)
    moved, turned = np.zeros_like(rates), np.zeros_like(after)
    shifts = np.diag([quad(change) * body.magnitude / i for i in body.inertia])
    for x, y, z in np.array(there.rates) + shifts:
        near = Rotation(body.inertia, (x, y, z)).state(after)
        moved = moved + np.abs(near[0] - rates) * (ULP / change)
        turned = turned + np.sqrt(((near[1] - attitude) ** 2).sum(axis=0)) * (ULP / change)
    late = times >= wait
    return np.concatenate([moved, *[turned[None]] * 4]) * late
