"""A user's own MuJoCo options as a method: what is taken, what is left, what is refused."""

import mujoco
import pytest

from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.user_file import HALVINGS, user_method
from plumbob.engines.method import USER_METHOD
from plumbob.engines.registry import method as find_method

MODEL = """
<mujoco>
  <option integrator="{integrator}" timestep="{step}" cone="elliptic" solver="CG" impratio="30"
          noslip_iterations="4" tolerance="1e-11" iterations="77" gravity="0 0 -1" density="5">
    <flag {flags}/>
  </option>
  <default>
    <geom solref="0.004 0.9" solimp="0.8 0.97 0.002" condim="4" friction="0.3"/>
    <default class="foot"><geom solref="0.5 1"/></default>
  </default>
  <worldbody><geom size="1"/></worldbody>
</mujoco>
"""


def written(folder, integrator="Euler", step="0.002", flags='contact="disable"'):
    """A model file with these options."""
    path = folder / "my.xml"
    path.write_text(MODEL.format(integrator=integrator, step=step, flags=flags), "utf-8")
    return path


INTEGRATORS = {
    "Euler": "mujoco/euler",
    "RK4": "mujoco/rk4",
    "implicit": "mujoco/implicit",
    "implicitfast": "mujoco/implicitfast",
}


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_options_are_taken(integrator, tmp_path):
    found = user_method(written(tmp_path, integrator))
    like = find_method(INTEGRATORS[integrator])
    steps = tuple(0.002 / 2**n for n in range(HALVINGS + 1))
    assert (found.name, found.engine, found.systems) == (USER_METHOD, "mujoco", ())
    assert (found.scheme, found.order, found.step_sizes) == (like.scheme, like.order, steps)
    assert found.settings["contact"]["tolerance"] == 1e-11  # with the contacts: scaled there
    spec = mujoco.MjSpec.from_string("<mujoco/>")
    before = [*spec.option.gravity, spec.option.density]
    options.apply(spec, found.settings, 0.5)
    wanted = {
        "integrator": getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}"),
        "cone": mujoco.mjtCone.mjCONE_ELLIPTIC,
        "solver": mujoco.mjtSolver.mjSOL_CG,
        "impratio": 30.0,
        "iterations": 77,
        "noslip_iterations": 4,
        "timestep": 0.5,
    }
    assert {name: getattr(spec.option, name) for name in wanted} == wanted
    # the scene is not taken from the user's file
    assert [*spec.option.gravity, spec.option.density] == before
    assert not spec.option.disableflags & int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
