"""What a model may do without: the same bits are the same bits, and a file without it has them."""

from dataclasses import dataclass, fields
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import MujocoModel
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.controls import script
from plumbob.engines.audit.trims import trims
from plumbob.engines.own_motion import Change
from plumbob.reports.cli import main
from plumbob.tests.audit.scenes_as_models import pendulum, ready

# A body that slides on a plane, beside geoms that it never touches, with sensors.
CLUTTERED = """
<mujoco>
  <option timestep="0.002" {option}/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 .1"/>
    {clutter}
    <body name="brick" pos="0 0 .0999"><freejoint/>
      <geom name="brick" type="box" size=".2 .1 .1" condim="{condim}" friction="{friction}"/>
      <site name="s"/></body>
  </worldbody>
  <sensor><accelerometer site="s"/><framequat objtype="site" objname="s"/></sensor>
  <keyframe><key qpos="0 0 .0999 1 0 0 0" qvel=".3 0 0 0 0 1"/></keyframe>
</mujoco>
"""
CLUTTER = "".join(
    f'<geom name="wall{i}" type="box" size=".1 .1 .1" pos="{x} {y} .5"/>'
    for i, (x, y) in enumerate((a, b) for a in (-2, -1, 1, 2) for b in (-2, 2))
)
PAIRS = "".join(f'<pair geom1="brick" geom2="{g}"/>' for g in ("floor", "wall0", "wall1"))
MODELS = {
    "cluttered": CLUTTERED.format(clutter=CLUTTER, option="", condim=3, friction=".4"),
    "elliptic": CLUTTERED.format(clutter="", option='cone="elliptic"', condim=4, friction=".6"),
    "rk4": CLUTTERED.format(clutter=CLUTTER, option='integrator="RK4"', condim=3, friction="1"),
    "gradients": CLUTTERED.format(
        clutter=CLUTTER, option='solver="CG"', condim=6, friction=".2"
    ),
    "pairs": CLUTTERED.format(clutter=CLUTTER, option="", condim=3, friction=".4").replace(
        "<sensor>", f"<contact>{PAIRS}</contact><sensor>"
    ),
    "pendulum": """<mujoco><worldbody><geom type="plane" size="1 1 1" pos="0 0 -3"/>
        <body><joint axis="0 1 0"/><geom size=".1" pos=".5 0 0"/></body></worldbody>
        <sensor><clock/></sensor><keyframe><key qvel="1"/></keyframe></mujoco>""",
}


def states(path, steps=200):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    found = []
    for _ in range(steps):
        mujoco.mj_step(model, data)
        found.append(np.concatenate([data.qpos, data.qvel]))
    return np.array(found)


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", MODELS)
def test_trimmed_file_moves_as_the_complete_one(name, tmp_path):
    source = tmp_path / "my.xml"
    target = tmp_path / "less.xml"
    source.write_text(MODELS[name], "utf-8")
    model = ready(source, 0)
    motion = script(model, duration=0.4, period=0.02)
    tried = trims(model, motion, 10, 20, 0.0, Allowance(20.0))
    names = [t.name for t in tried.each if t.same_bits]
    assert "sensors" in names
    if name != "elliptic":
        assert any(n.startswith("collisions of") for n in names)
    if name == "pairs":
        assert "2 contact pairs that never touch" in names
    changes = [c for t in tried.each if t.same_bits for c in t.changes]
    from plumbob.engines.adapters.mujoco.own_model.file_text import (
        write_without as write_trimmed,
    )

    write_trimmed(source, changes, target)
    assert np.array_equal(states(source), states(target))
    assert "nsensor" not in target.read_text("utf-8")


@dataclass(frozen=True)
class Nudged(MujocoModel):
    """A model that offers to fall faster by one part in 10^12."""

    def changes(self, motion):
        return (Change("nudge", ()),)

    def changed(self, changes):
        model = super().changed(())
        model.effective.opt.gravity[2] *= 1 + 1e-12
        return model


def test_smallest_change_is_not_the_same():
    whole = ready(pendulum())
    nudged = Nudged(**{f.name: getattr(whole, f.name) for f in fields(MujocoModel)})
    motion = script(nudged, duration=0.4)
    (trim,) = trims(nudged, motion, 2, 20, 0.0, Allowance(5.0)).each
    assert not trim.same_bits
    assert 0.0 < trim.moved < 1e-11
    assert not trim.accepted(0.0)
    assert not trim.accepted(9 * trim.moved)
    assert trim.accepted(11 * trim.moved)


@pytest.mark.long
def test_command_writes_the_trimmed_model(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("my.xml").write_text(MODELS["cluttered"], "utf-8")
    short = ["audit", "my.xml", "--keyframe", "0", "--duration", "0.2", "--budget", "10"]
    for refused in ("my.xml", f"{'long' * 99}.xml", "none/less.xml"):
        assert main([*short, "--write-trimmed", refused]) == 2
        out, err = capsys.readouterr()
        assert (out, "does not exist yet" in err) == ("", True)
    assert Path("my.xml").read_text("utf-8") == MODELS["cluttered"]
    code = main([*short, "--write-trimmed", "less.xml"])
    printed = capsys.readouterr()
    # What saves time is measured, and may be nothing on a busy machine.
    assert code == 0 or "nothing can be left out" in printed.err
    assert Path("less.xml").exists() == (code == 0)
