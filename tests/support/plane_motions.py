"""Loads of motions in the plane at given times, for tests."""

import numpy as np

from plumbob.analytic.systems.three_points.forces import moving, resting
from plumbob.analytic.systems.three_points.smooth_segment import monotone_root

SAMPLES = 129  # of a smooth piece, for the search of its lowest normal force


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
