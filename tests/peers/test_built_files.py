"""An audit's engines: what a reader of files drops is no error of the engine.

An engine's reader is given a file that has lost one thing, and plumbob builds the whole model."""

from dataclasses import replace

import pytest

from plumbob.engines.abilities import BuildsMechanisms, RunsFiles
from plumbob.engines.audit.engines import file_error
from plumbob.engines.registry import engines, find_engine, installed
from plumbob.tests.support.engines_beside import changed, held

ARM = """<mujoco model="arm"><compiler {compiler}/><option timestep="0.0004"/>
<worldbody><body name="upper" pos="0 0 1">
  <joint name="shoulder" axis="0 1 0" damping="{damping}"/>
  <inertial pos="0.05 0 -0.2" mass="1" diaginertia="0.02 0.02 0.005"/>
  <body name="lower" pos="0 0 -0.4"><joint axis="0.6 0.8 0" stiffness="{stiffness}"/>
    <inertial pos="0.02 0 -0.15" mass="0.5" fullinertia="{inertia}"/></body></body>
</worldbody><actuator><motor name="motor" joint="shoulder" gear="{gear}"/></actuator></mujoco>"""
WHOLE = {
    "compiler": 'settotalmass="3"',
    "damping": 0.3,
    "inertia": "0.03 0.03 0.03 0.012 0.004 0.002",
    "stiffness": 2,
    "gear": 3,
}
LOSSES = {
    "damping of a joint": {"damping": 0},
    "axes of an inertia": {"inertia": "0.03 0.03 0.03 0 0 0"},
    "gear": {"gear": 1},
    "settotalmass": {"compiler": 'angle="radian"'},
    "stiffness of a joint without a name": {"stiffness": 0},
}
FACTOR = 2.0  # of a step's error in MuJoCo by the same scheme: turns differ in their update
BUILDERS = [
    name
    for name, engine in engines().items()
    if engine.ability(BuildsMechanisms) and installed(engine)
]
MUJOCO = changed().ability(RunsFiles)


def _reading(name, file):
    """An engine that builds mechanisms, whose reader is MuJoCo's, and reads this file whatever it
    is given."""
    reads = RunsFiles(lambda _, layout, step: MUJOCO.load(file, layout, step))
    engine = find_engine(name)
    return replace(engine, abilities=(engine.ability(BuildsMechanisms), reads))


@pytest.mark.long(keep=len(BUILDERS))
@pytest.mark.parametrize("name", BUILDERS)
@pytest.mark.parametrize("loss", LOSSES)
def test_the_readers_loss_is_not_the_engines(name, loss, tmp_path):
    """The error of the engine as built is that of its step in MuJoCo, to 1 % of what the lost
    number moves, and within FACTOR; a loss that stays in the build is a hundred times as large. The
    short suite has a loss of each engine."""
    (whole := tmp_path / "whole.xml").write_text(ARM.format(**WHOLE), "utf-8")
    (read := tmp_path / "read.xml").write_text(ARM.format(**WHOLE | LOSSES[loss]), "utf-8")
    result = file_error(_reading(name, read), held(whole, control="sines", duration=0.4))
    assert (result.why, result.not_built) == ("", "")
    assert result.left == result.built
    assert abs(result.built - result.step_error) < 0.01 * result.error
    assert result.step_error / FACTOR < result.built < result.step_error * FACTOR
    assert result.part_explained == pytest.approx(1.0 - result.built / result.error)
