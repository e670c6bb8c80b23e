"""Loads of motions in the plane at given times, for tests."""

import numpy as np

from plumbob.analytic.systems.three_points.forces import loading
from plumbob.analytic.systems.three_points.smooth_segment import monotone_root

SAMPLES = 129  # of a smooth piece, for the search of its lowest normal force


def loadings(motion, times):
    """For each segment that contains some of `times` [s], shape (n,), their loading."""
    times = np.atleast_1d(np.asarray(times, dtype=np.float64))
    which = np.clip(np.searchsorted(motion.begins, times, side="right") - 1, 0, None)
    for index in np.unique(which):
        segment = motion.segments[index]
        local = times[which == index] - motion.path.breakpoints[segment.interval.number]
        inside = np.clip(local, segment.start, segment.end)
        places = monotone_root(segment.coefficients[:, 3], inside)
        yield loading(motion, segment, places / segment.last)
