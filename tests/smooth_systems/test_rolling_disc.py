"""The rolling disc against Newton's and Euler's vector equations, closed forms, and 25 digits."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp

from plumbob.analytic.errors.contact_models.disc_steps import ROLLS, disc_errors
from plumbob.analytic.schemes import EULER, Scheme, SoftPoint
from plumbob.engines.registry import method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene

DISC = case_of(scene("rolling-disc/falling")).problem
CIRCLE = case_of(scene("rolling-disc/circle")).problem


def rolled(disc, time):
    """Tilt, precession and spin by Taylor series of the rates about the disc's own axes, with the
    tilt as another unknown."""
    pull = mp.mpf(disc.gravity) / mp.mpf(disc.radius)

    def slopes(_, y):
        tilt, leans, turn, axial, *_ = y
        # turn = f' sin t
        c = mp.cos(tilt)
        s = mp.sin(tilt)
        around = turn / s
        return [
            leans,
            (turn * around * c / 4 - 1.5 * turn * axial - pull * c) * mp.mpf(4) / 5,
            2 * axial * leans - leans * around * c,
            mp.mpf(2) / 3 * turn * leans,
            around,
            axial - around * c,
        ]

    tilt = mp.mpf(disc.tilt)
    turn = mp.mpf(disc.precession_rate)
    start = [tilt, mp.mpf(disc.tilt_rate), turn * mp.sin(tilt)]
    start += [disc.spin_rate + turn * mp.cos(tilt), mp.mpf(0), mp.mpf(0)]
    end = mp.odefun(slopes, 0, start)(mp.mpf(time))
    return {"tilt": end[0], "precession": end[4], "spin": end[5]}


def test_25_digits():
    time = 0.125
    exact = DISC.motion.observe(np.array([time]))
    doubt = DISC.motion.uncertainty(np.array([time]))
    with mp.workdps(25):
        for name, value in rolled(DISC, time).items():
            assert abs(value - mp.mpf(exact[name][0])) <= doubt[name][0] < 1e-13


@pytest.mark.parametrize("step", [3e-3, 7e-4])
@pytest.mark.parametrize("case", ["circle", "falling"])
def test_runs_are_predicted_to_nine_digits(case, step):
    of = case_of(scene(f"rolling-disc/{case}"))
    how = method("mujoco/euler+coulomb")
    for error in measure(of, how, step)[0].errors.values():
        assert error.predicted
        assert error.predicted.difference < 1e-9 < 1e-3 < error.largest


def test_rounding_uses_a_part_of_its_bound():
    """A tenth and more: ROUNDED is calibrated."""
    of = case_of(scene("rolling-disc/circle"))
    how = method("mujoco/euler+coulomb")
    error = measure(of, how, 3e-3)[0].errors["tilt"]
    assert 0.1 < error.predicted.difference / error.left_open < 1.0


def test_nothing_is_predicted_of_a_disc_that_slips_or_of_soft_contacts():
    times = np.array([0.1])
    scheme = Scheme(EULER, contact=ROLLS)
    assert disc_errors(DISC).at_step(scheme, 1e-3, times).errors
    steep = replace(CIRCLE, precession_rate=12.0, spin_rate=30.0)
    assert not disc_errors(steep).at_step(scheme, 1e-3, times).errors
    soft = Scheme(EULER, contact=SoftPoint())
    assert not disc_errors(DISC).at_step(soft, 1e-3, times).errors
