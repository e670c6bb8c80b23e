"""The first verdict of an audit: two runs, before any reference, and the certificate after it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.audit.controls import script
from plumbob.engines.audit.first_verdict import affordable, first_verdict
from plumbob.engines.audit.user_models import user_models
from plumbob.engines.own_motion import AS_IT_STANDS

ROD = """<mujoco><option timestep="{step}" integrator="{integrator}"/><worldbody><body>
<joint axis="0 1 0"/><geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>"""


@pytest.fixture
def rod(tmp_path):
    """Writes a rod with a step and an integrator."""

    def written(step, integrator="Euler"):
        file = tmp_path / "rod.xml"
        file.write_text(ROD.format(step=step, integrator=integrator))
        return file

    return written


# The error at a step follows from the difference to half of it but for the next power of the step,
# a fraction of a per cent of it here; rounding adds about 1e-13 m of the 1e-8 m of RK4.
@pytest.mark.parametrize(("integrator", "step"), [("Euler", 1e-3), ("RK4", 1e-2)])
def test_the_estimate_is_the_error_of_a_smooth_motion(rod, integrator, step):
    """Beside a run of RK4 at a step that is far smaller."""
    model = user_models().model(rod(step, integrator), AS_IT_STANDS)
    motion = script(model, "rest", 0.4)
    fine = (
        user_models()
        .model(rod(1e-4, "RK4"), AS_IT_STANDS)
        .stepped(motion, "rk4", motion.parts(1e-4))
    )
    own = model.stepped(motion, model.integrator, motion.parts(step))
    error = float(
        np.linalg.norm(model.corners(own.states) - model.corners(fine.states), axis=2).max()
    )
    verdict = first_verdict(model, motion)
    assert verdict.estimate == pytest.approx(error, rel=0.02)
    assert (verdict.ends_at, verdict.why, verdict.remarks) == (None, "", ())


def test_a_run_that_ends_early_has_no_estimate(rod):
    """Its time is the last that is known."""
    model = user_models().model(rod(1e-2), AS_IT_STANDS)
    motion = script(model, "rest", 0.4)

    class Ending:
        """The model, whose runs end halfway."""

        def __getattr__(self, name):
            return getattr(model, name)

        def stepped(self, *arguments):
            run = model.stepped(*arguments)
            states = run.states.copy()
            states[len(states) // 2 :] = np.nan
            return replace(run, states=states, why="it falls")

    verdict = first_verdict(Ending(), motion)
    count = len(motion.times) // 2
    assert (verdict.ends_at, verdict.why) == (motion.times[count - 1], "it falls")
    assert math.isnan(verdict.change)


@pytest.mark.parametrize(("seconds", "periods"), [(1.2, 40), (0.3, 10), (0.02, 0)])
def test_runs_that_would_take_too_long_are_shorter(rod, seconds, periods):
    """Of 40 periods of one step, a step takes 10 ms, and half of it twice that."""
    model = user_models().model(rod(1e-2), AS_IT_STANDS)
    motion = replace(script(model, "rest", 0.4), period=1e-2, controls=np.zeros((40, 0)))

    class Slow:
        """The model, whose steps take 10 ms."""

        def __getattr__(self, name):
            return getattr(model, name)

        def stepped(self, *arguments):
            return replace(model.stepped(*arguments), seconds=0.01)

    short = affordable(Slow(), motion, seconds)
    assert (0 if short is None else len(short.controls)) == periods
