"""A user's own MuJoCo options as a method: what is taken, what is left, what is refused."""

from dataclasses import replace

import mujoco
import pytest

from plumbob.engines.adapters.mujoco import options
from plumbob.engines.adapters.mujoco.user_file import HALVINGS, user_method
from plumbob.engines.method import USER_METHOD
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.verdict import judge

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
    found, like = user_method(written(tmp_path, integrator)), find_method(INTEGRATORS[integrator])
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


@pytest.mark.parametrize(
    "name", ["simple-pendulum/damped-large", "linear-pendulum/damped-large", "cone-pendulum"]
)
@pytest.mark.parametrize(
    ("integrator", "flags"),
    [
        ("Euler", 'contact="disable"'),
        ("Euler", 'eulerdamp="disable"'),
        ("implicitfast", 'eulerdamp="disable"'),
        ("RK4", 'warmstart="disable"'),
    ],
)
def test_a_user_method_is_measured_as_any_other(name, integrator, flags, tmp_path):
    case = case_of(replace(find_scene(name), duration=0.5))
    found = user_method(written(tmp_path, integrator, "0.0005", flags))

    def verdict(method):
        run, _ = measure(case, method, method.step_sizes[0])
        return judge(run, case.system, method).verdict

    assert verdict(found) == "predicted"
    if name != "cone-pendulum" and integrator != "RK4":
        # explicit or implicit damping makes the difference
        other = replace(found.scheme, implicit_damping=not found.scheme.implicit_damping)
        assert verdict(replace(found, scheme=other)) == "off-prediction"
