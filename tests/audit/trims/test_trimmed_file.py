"""A trimmed file is the user's text: numbers keep their digits, and its bits are what is said."""

from dataclasses import replace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.own_model.file_text import write_without as write_trimmed
from plumbob.engines.audit.costs import Ratio
from plumbob.engines.audit.trims import Trim, Trims
from plumbob.engines.own_motion import Change
from plumbob.reports.commands.audit import write_trimmed_file
from plumbob.reports.view.audit.page import answer_rows, audit_answer
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


SENSORS = without("sensor")
SPRINGS = without("spring")


def test_digits_of_the_file_stay(tmp_path):
    source = tmp_path / "my.xml"
    target = tmp_path / "less.xml"
    source.write_text(DIGITS.format(wall=WALL), "utf-8")
    changes = (never_touching(source, "wall"), SENSORS)
    assert write_trimmed(source, changes, target) == changes
    assert np.array_equal(states(source), states(target))
    text = target.read_text("utf-8")
    assert "<!-- a comment with <geom/> and </mujoco> in it -->" in text
    *written, option, flag = ElementTree.fromstring(text).iter()
    for old, new in zip(ElementTree.parse(source).iter(), written, strict=True):
        off = {"contype": "0", "conaffinity": "0"} if old.get("name") == "wall" else {}
        assert (new.tag, new.attrib) == (old.tag, {**old.attrib, **off})
    assert (option.tag, option.attrib, flag.attrib) == ("option", {}, {"sensor": "disable"})
    assert sorted(p.name for p in tmp_path.iterdir()) == ["less.xml", "my.xml"]


def test_included_geoms_and_copies(tmp_path):
    """An included file takes the place of its include; geoms that
    one element makes are left out all or not at all."""
    source = tmp_path / "my.xml"
    target = tmp_path / "less.xml"
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "wall.xml").write_text(f"<mujocoinclude>{WALL}</mujocoinclude>\n")
    (tmp_path / "more.xml").write_text(
        '<mujoco><include file="parts/wall.xml"/><geom name="far" size=".1" pos="9 9 9"/></mujoco>'
    )
    (tmp_path / "light.xml").write_text("<mujoco><statistic extent='2'/></mujoco>")
    copies = (
        '<replicate count="3" offset="0 0 3"><geom name="c" size=".1" pos="4 4 4"/></replicate>'
    )
    inside = f'<include file="more.xml"/>{copies}'
    text = DIGITS.format(wall=inside).replace("<sensor>", '<include file="light.xml"/><sensor>')
    source.write_text(text, "utf-8")
    whole = never_touching(source, "wall", "far", "c0", "c1", "c2")
    assert write_trimmed(source, (whole,), target) == (whole,)
    written = target.read_text("utf-8")
    assert "include" not in written
    model = mujoco.MjModel.from_xml_path(str(target))
    assert [model.geom(n).contype[0] for n in ("wall", "far", "c0", "c2", "floor")] == [
        0
    ] * 4 + [1]
    target.unlink()
    some = never_touching(source, "far", "c0", "c1")
    (kept,) = write_trimmed(source, (some,), target)
    assert kept.name == "geoms (2 of 6 settings)"
    assert "more.xml" not in target.read_text("utf-8")
    model = mujoco.MjModel.from_xml_path(str(target))
    assert [model.geom(n).contype[0] for n in ("far", "wall", "c0", "c1")] == [0, 1, 1, 1]
    target.unlink()
    with pytest.raises(ParameterError, match="no text of its own"):
        write_trimmed(source, (never_touching(source, "c0"),), target)
    assert not target.exists()


def audited(path, changes):
    """An audit that found that `changes` can be left out together."""
    found = plumbob.audit(path, duration=0.3, budget=10.0)
    together = Trim(changes, True, 0.0, Ratio(0.5, 0.5, 0.5))
    return replace(found, trims=Trims((), together))


@pytest.mark.long
@pytest.mark.parametrize("same", [True, False])
def test_what_is_said_is_what_the_file_does(same, tmp_path):
    """Its bits, whatever was found of the model before it was written."""
    source = tmp_path / "my.xml"
    target = tmp_path / "less.xml"
    source.write_text(DIGITS.format(wall=WALL), "utf-8")
    changes = (SENSORS if same else SPRINGS,)
    found = write_trimmed_file(audited(source, changes), source, target)
    assert np.array_equal(states(source, 150), states(target, 150)) == same
    said = dict(answer_rows(audit_answer(found)))["trimmed file"]
    assert said.startswith("less.xml, read back, moves ")
    assert ("to the last bit" in said) == same
    assert (found.written[1].moved == 0.0) == same
    data = record(found)["trimmed_file"]
    assert data["same_bits"] == same
    assert data["left_out"] == changes[0].name
