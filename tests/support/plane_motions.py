"""Motions in the plane for tests: slider paths given by any function, loads at given times, and the
closed form of coasting about a support at rest."""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Segment, normal_forces
from plumbob.analytic.systems.manoeuvres.residual_motion import Coasting, ResidualMotion
from plumbob.analytic.systems.slider_path import Kinematics
from plumbob.analytic.systems.three_points.forces import moving, resting
from plumbob.analytic.systems.three_points.smooth_segment import monotone_root

SAMPLES = 129  # of a smooth piece, for the search of its lowest normal force


@dataclass(frozen=True)
class SmoothPiece:
    """Any motion given as a function of local time, smooth on (0, duration) and a little beyond."""

    duration: float
    motion: Callable[[Array], Kinematics]

    def kinematics(self, times):
        """See Piece."""
        return self.motion(times)

    def track(self):
        """Straight lines between samples: see Piece."""
        places = self.motion(np.linspace(0.0, self.duration, SAMPLES))[0]
        corners = [(float(x), float(y)) for x, y in places]
        return tuple(Segment(a, b) for a, b in itertools.pairwise(corners))


def loading(motion, times):
    """Loadings at `times` [s], shape (n,): for each segment that contains some of them, those times
    and its loading."""
    times = np.atleast_1d(np.asarray(times, dtype=np.float64))
    which = np.clip(np.searchsorted(motion.begins, times, side="right") - 1, 0, None)
    loadings = []
    for index in np.unique(which):
        segment, instants = motion.segments[index], times[which == index]
        local = instants - motion.path.breakpoints[segment.piece]
        if segment.coefficients is None:
            loadings.append((instants, resting(motion, segment, local)))
        else:
            inside = np.clip(local, segment.start, segment.end)
            places = monotone_root(segment.coefficients[:, 3], inside, segment.last)
            loadings.append((instants, moving(motion, segment, places)))
    return loadings


def pivoting(capsule, slider, support, rate):
    """Coasting at `rate` [rad/s] about support A_1, A_2 or A_3 at rest, Q at `slider` relative to C
    [m]: J_A omega' = -f sum N_i |A_i - A|, J_A the inertia of body and slider about A. The support
    sticks (asserted). Chernousko 2020, eqs. 1-4 with one support at rest."""
    normal = normal_forces(capsule, np.array([slider]))[0]
    corners, masses = np.asarray(capsule.supports), (capsule.body_mass, capsule.slider_mass)
    arms = corners - corners[support - 1]
    lengths = np.hypot(arms[:, 0], arms[:, 1])
    to_com, to_slider = -corners[support - 1], np.asarray(slider) - corners[support - 1]
    inertia = capsule.inertia + masses[0] * to_com @ to_com + masses[1] * to_slider @ to_slider
    coasting = Coasting(rate, float(capsule.friction * normal @ lengths / inertia))
    others = lengths > 0.0
    drag = capsule.friction * ((normal[others] / lengths[others]) @ arms[others])
    moment = masses[0] * to_com + masses[1] * to_slider
    # Turned a quarter, k x arm: friction of the sliding supports, tangential acceleration.
    across = math.copysign(1.0, rate) * (drag - coasting.deceleration * moment)
    tangential = np.array([-across[1], across[0]])
    for squared in (0.0, rate**2):  # the force needed is convex in omega^2: the ends decide
        needed = float(np.linalg.norm(tangential - squared * moment))
        assert needed <= capsule.friction * normal[support - 1]
    return ResidualMotion(capsule, coasting, capsule.supports[support - 1], slider=slider)
