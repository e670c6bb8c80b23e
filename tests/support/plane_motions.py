"""Motions in the plane for tests: slider paths given by any function, loads at given times, and the
closed form of coasting about a support at rest."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plumbob.analytic.reference import Array
from plumbob.analytic.systems.capsule import Segment
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
