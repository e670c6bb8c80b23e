"""When a crank of uniform links passes an angle: an integral of the energy, in mpmath's digits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from mpmath import mp

Places = Callable[[Any], Sequence[tuple[Any, ...]]]


def passed(
    places: Places,
    masses: Sequence[Any],
    lengths: Sequence[Any],
    gravity: Any,
    ends: tuple[Any, Any],
    rate: Any,
) -> Any:
    """Time [s] from one of two angles [rad] to the other, of a crank that begins at a `rate`
    [rad/s]; `places` are x, y and the angle of each link by the crank's, and speeds their
    differences."""

    def energies(t: Any) -> tuple[Any, Any]:
        half, height = mp.mpf(0), mp.mpf(0)
        for i, (mass, length) in enumerate(zip(masses, lengths, strict=True)):
            x, y, turn = (mp.diff(lambda s, k=k, i=i: places(s)[i][k], t) for k in range(3))
            half += mass * (x**2 + y**2 + length**2 / 12 * turn**2) / 2
            height += mass * gravity * places(t)[i][1]
        return half, height

    half, height = energies(ends[0])
    total = half * rate**2 + height

    def slowness(t: Any) -> Any:
        half, height = energies(t)
        return mp.sqrt(half / (total - height))

    return mp.quad(slowness, mp.linspace(*ends, 3))
