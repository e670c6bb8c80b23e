"""A trimmed file is the user's text: numbers keep their digits, and its bits are what is said."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.own_model.file_text import write as write_trimmed
from plumbob.engines.audit.costs import Ratio
from plumbob.engines.audit.trims import Trim, Trims
from plumbob.engines.own_motion import Change
from plumbob.reports.commands.audit import trimmed_file
from plumbob.reports.view.audit.page import answered, rows
from plumbob.reports.view.audit.records import record
from plumbob.tests.audit.trims.test_audit_trims import states

# Digits that MuJoCo's own writer rounds: a range in degrees that is reached, a spring's length.
DIGITS = """<?xml version="1.0"?>
<mujoco model="digits">  <!-- a comment with <geom/> and </mujoco> in it -->
  <default><geom contype="1"/><default class="foot"><geom condim="6" rgba="1 0 0 1"/></default>
  </default>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 .1"/>
    {wall}
    <body pos=".1234567890123 0 1"><joint name="j" axis="0 1 0" limited="true"
        range="-12.345678901234 7.6543210987654"/>
      <geom class="foot" type='capsule' size=".02" fromto="0 0 0 .5 0 0" name='a "contype" name'/>
      <site name="tip" pos=".5 0 0"/></body>
    <site name="hook" pos="0 0 2"/>
  </worldbody>
  <tendon><spatial springlength="1.0123456789012" stiffness="12.3456789"><site site="tip"/>
    <site site="hook"/></spatial></tendon>
  <sensor><clock/></sensor>
</mujoco>
"""
WALL = '<geom name="wall" type="box" size=".1 .1 .1" pos="3 0 0" contype="1"/>'


def never_touching(path, *names):
    """Collisions of these geoms off."""
    model = mujoco.MjModel.from_xml_path(str(path))
    ids = tuple(int(model.geom(name).id) for name in names)
    return Change("geoms", (("geom_contype", ids, 0), ("geom_conaffinity", ids, 0)))


def without(stage):
    """A stage of the pipeline off."""
    bit = getattr(mujoco.mjtDisableBit, f"mjDSBL_{stage.upper()}")
    return Change(stage, (("disableflags", (), int(bit)),))


SENSORS, SPRINGS = without("sensor"), without("spring")
FEW = Change("iterations above 20", (("iterations", (), 20),))


def test_the_file_is_the_users_text_and_options(tmp_path):
    """Geoms stay: options alone are written, and where there are none nothing is."""
    source, target = tmp_path / "my.xml", tmp_path / "less.xml"
    source.write_text(DIGITS.format(wall=WALL), "utf-8")
    walls = never_touching(source, "wall")
    assert write_trimmed(source, (walls, SENSORS, FEW), target) == (SENSORS, FEW)
    assert np.array_equal(states(source), states(target))
    option = '<option iterations="20"><flag sensor="disable" /></option>'
    end = "</mujoco>\n"
    assert target.read_text("utf-8") == source.read_text("utf-8").removesuffix(end) + (
        f"{option}\n{end}"
    )
    target.unlink()
    with pytest.raises(ParameterError, match="no option leaves out"):
        write_trimmed(source, (walls,), target)
    assert [p.name for p in tmp_path.iterdir()] == ["my.xml"]


def audited(path, changes):
    """An audit that found that `changes` can be left out together."""
    found = plumbob.audit(path, duration=0.3, budget=10.0)
    together = Trim(changes, True, 0.0, Ratio(0.5, 0.5, 0.5))
    return replace(found, trims=Trims((), together))


@pytest.mark.long
@pytest.mark.parametrize("same", [True, False])
def test_what_is_said_is_what_the_file_does(same, tmp_path):
    """Its bits, whatever was found of the model before it was written."""
    source, target = tmp_path / "my.xml", tmp_path / "less.xml"
    source.write_text(DIGITS.format(wall=WALL), "utf-8")
    changes = (SENSORS if same else SPRINGS,)
    found = trimmed_file(audited(source, changes), source, target)
    assert np.array_equal(states(source, 150), states(target, 150)) == same
    said = dict(rows(answered(found)))["trimmed file"]
    assert said.startswith("less.xml, read back, moves ")
    assert ("to the last bit" in said) == same
    assert (found.written[1].moved == 0.0) == same
    data = record(found)["trimmed_file"]
    assert data["same_bits"] == same
    assert data["left_out"] == changes[0].name
