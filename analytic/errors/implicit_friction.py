"""Coulomb friction of three points solved within a step: it opposes the slip at the step's end.

With u the body's velocity at the combined centre and o its rate after the step, P and w those
without friction, kappa the time over which friction acts, L_i = f N_i, a_i = CA_i - mu r,

    (M + m)|u - P|^2/2 + I (o - w)^2/2 + kappa sum L_i |u + o k x a_i|  is least.

That is implicit in the direction of friction, and in whether a support slips. The least value is at
a kink where a support is at rest: about one support the body turns at a rate that is known in
closed form. Else Newton's method finds it. Chernousko 2020, eq. 1, in the manner of Moreau.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.systems.three_points.rest import load_factor

NEWTON_STEPS = 60
QUICK = 12  # of undamped steps from the last step's slip
LAST = 2e-15  # of the velocities: a step this small ends Newton's method
HELD = 1e-12  # a force this near its limit, relatively, still holds

Slip = tuple[complex, float]  # velocity of the body's point at the combined centre, and rate


@dataclass(frozen=True, slots=True)
class Grip:
    """Masses (M + m) [kg] and I [kg m^2], friction kappa L_i [N s] and arms a_i [m]; `offsets`
    [m/s] are what slips have beside u + o k x a_i, too little to count where a support rests."""

    mass: float
    inertia: float
    limits: Sequence[float]
    arms: Sequence[complex]
    offsets: Sequence[complex] = (0j, 0j, 0j)

    def value(self, free: Slip, slip: Slip) -> float:
        """What is to be least."""
        (u, o), (p, w) = slip, free
        supports = zip(self.limits, self.arms, self.offsets, strict=True)
        drag = sum(c * abs(u + 1j * o * a + g) for c, a, g in supports)
        return 0.5 * self.mass * abs(u - p) ** 2 + 0.5 * self.inertia * (o - w) ** 2 + drag


def after_friction(grip: Grip, free: Slip, near: Slip) -> Slip:
    """Velocities after a step that would end with `free` were there no friction; `near`, those
    after the step before, is where to look first."""
    scale = abs(free[0]) + abs(free[1]) * max(abs(arm) for arm in grip.arms)
    if scale == 0.0 or _shared(grip, free):
        return 0j, 0.0
    if (found := _sliding(grip, free, near, scale, QUICK, damped=False)) is not None:
        return found
    pins = [_pinned(grip, free, i) for i in range(3)]
    for slip, excess, _ in pins:
        if slip[1] != 0.0 and excess <= 0.0:
            return slip
    slip, excess, push = min(pins, key=lambda pin: grip.value(free, pin[0]))
    if slip[1] != 0.0:
        aside = push / abs(push) * excess / grip.mass
        begin = _below(grip, free, slip, (aside, 0.0))
    else:
        limits, arms = np.array(grip.limits), np.array(grip.arms)
        factor, way = load_factor(limits, arms, grip.mass * free[0], grip.inertia * free[1])
        if factor <= 1.0 + HELD:
            return 0j, 0.0
        size = scale / (math.hypot(way[0], way[1]) + abs(way[2]) * float(np.abs(arms).max()))
        leaving = (size * complex(way[0], way[1]), size * float(way[2]))
        begin = _below(grip, free, slip, leaving)
    found = _sliding(grip, free, begin, scale, NEWTON_STEPS, damped=True)
    return begin if found is None else found


def _shared(grip: Grip, free: Slip) -> bool:
    """Whether impulses kappa L_i (X + Y k x a_i) hold the body: enough to be at rest."""
    spread = sum(c * abs(a) ** 2 for c, a in zip(grip.limits, grip.arms, strict=True))
    total = sum(grip.limits)
    if not total > 0.0:
        return False
    along, about = grip.mass * free[0] / total, 1j * grip.inertia * free[1] / spread
    return all(abs(along + about * arm) <= 1.0 for arm in grip.arms)


def _pinned(grip: Grip, free: Slip, pin: int) -> tuple[Slip, float, complex]:
    """Velocities with support `pin` held, by how much its impulse is beyond its limit, and the
    impulse that the body lacks there."""
    arm, (p, w) = grip.arms[pin], free
    turn = grip.inertia * w + grip.mass * (p * (1j * arm).conjugate()).real * -1.0
    drag = sum(
        c * abs(a - arm)
        for k, (c, a) in enumerate(zip(grip.limits, grip.arms, strict=True))
        if k != pin
    )
    if abs(turn) <= drag:
        return (0j, 0.0), math.inf, 0j
    o = (turn - math.copysign(drag, turn)) / (grip.inertia + grip.mass * abs(arm) ** 2)
    u = -1j * o * arm
    push = grip.mass * (p - u)
    for k in range(3):
        if k != pin:
            v = u + 1j * o * grip.arms[k]
            push -= grip.limits[k] * v / abs(v)
    return (u, o), abs(push) - grip.limits[pin] * (1.0 + HELD), push


def _below(grip: Grip, free: Slip, kink: Slip, way: Slip) -> Slip:
    """A place on the `way` from a kink at which the value is lower."""
    level, part = grip.value(free, kink), 1.0
    while part > 1e-30:
        there = (kink[0] + part * way[0], kink[1] + part * way[1])
        if grip.value(free, there) < level:
            return there
        part *= 0.5
    return kink


def _sliding(
    grip: Grip, free: Slip, begin: Slip, scale: float, most: int, *, damped: bool
) -> Slip | None:
    """The least value by Newton's method from `begin`; None where a slip vanishes on the way, or
    the last of `most` steps is no small one."""
    (x, y), o = (begin[0].real, begin[0].imag), begin[1]
    (px, py), w, mass = (free[0].real, free[0].imag), free[1], grip.mass
    reach = max(abs(arm) for arm in grip.arms)
    for _ in range(most):
        gx, gy, go = mass * (x - px), mass * (y - py), grip.inertia * (o - w)
        hxx = hyy = mass
        hxy = hxo = hyo = 0.0
        hoo = grip.inertia
        for limit, arm, beside in zip(grip.limits, grip.arms, grip.offsets, strict=True):
            ax, ay = arm.real, arm.imag
            vx, vy = x - o * ay + beside.real, y + o * ax + beside.imag
            slip = math.hypot(vx, vy)
            if slip <= LAST * scale:
                return None
            ex, ey, stiff = vx / slip, vy / slip, limit / slip
            gx, gy, go = gx + limit * ex, gy + limit * ey, go + limit * (ax * ey - ay * ex)
            across = ex * ax + ey * ay  # of the arm turned a quarter, on the normal of the slip
            hxx, hyy, hxy = hxx + stiff * ey * ey, hyy + stiff * ex * ex, hxy - stiff * ex * ey
            hxo, hyo = hxo - stiff * ey * across, hyo + stiff * ex * across
            hoo += stiff * across * across
        c11, c12, c13 = hyy * hoo - hyo * hyo, hxo * hyo - hxy * hoo, hxy * hyo - hxo * hyy
        c22, c23, c33 = hxx * hoo - hxo * hxo, hxy * hxo - hxx * hyo, hxx * hyy - hxy * hxy
        det = hxx * c11 + hxy * c12 + hxo * c13
        if det == 0.0:
            return None
        dx = -(c11 * gx + c12 * gy + c13 * go) / det
        dy = -(c12 * gx + c22 * gy + c23 * go) / det
        do = -(c13 * gx + c23 * gy + c33 * go) / det
        part = 1.0
        if damped:
            level, slope = grip.value(free, (complex(x, y), o)), gx * dx + gy * dy + go * do
            while part > 1e-12:
                there = (complex(x + part * dx, y + part * dy), o + part * do)
                if grip.value(free, there) <= level + 1e-4 * part * slope:
                    break
                part *= 0.5
        x, y, o = x + part * dx, y + part * dy, o + part * do
        if abs(dx) + abs(dy) + abs(do) * reach <= LAST * scale:
            return complex(x, y), o
    return (complex(x, y), o) if damped else None
