"""A pendulum released next to its top, by the complement of its angle: the start of engines that
store the angle as a double. Its exact motion is held to 40 digits in test_pendulum_motion."""

import pytest

from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene


def test_the_error_bar_covers_rounding_of_the_start():
    # The error of an integrator of accuracy 1e-15 is this one; at 1e-12 it is 4.2e-4 rad.
    pytest.importorskip("heyoka")
    for k, size in ((6, 3.6e-10), (9, 4.1e-7), (12, 4.2e-4)):
        scene = find_scene(f"simple-pendulum/near-top-1e-{k}")
        how = find_method("heyoka/taylor")
        found = measure(case_of(scene), how, 1e-15)[0]
        assert found.steps > 300  # one evaluation an order of each step, of some twenty
        error = found.errors["theta"]
        assert error.largest == pytest.approx(size, rel=0.15)
        assert error.largest < error.uncertainty < 10 * error.largest
