"""A fixed file is the user's text with the advice in it; its audit finds the promised error."""

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.own_model.file_text import write_fixed
from plumbob.engines.own_motion import FileFix
from plumbob.reports.advice.fixed_file import NothingToFix
from plumbob.reports.cli import main

FIX = FileFix({"timestep": "0.001", "integrator": "implicitfast"}, False, (), 0.0)
NEW = 'timestep="0.001" integrator="implicitfast"'
# A pendulum, with places for options and a joint's attributes.
ROD = """<?xml version="1.0"?>
<!-- <option timestep="9"/> in a comment -->
<mujoco model='rod'>
  {head}
  <worldbody>
    <body><joint name="j"   axis='0 1 0' {joint}/>  <!-- spaces stay -->
      <geom size=".1" pos=".5 0 0"/></body>
  </worldbody>
  {tail}
</mujoco>
"""
OPTION = "<option  gravity=\"0 0 -5\"\n   timestep = '0.004' />"
FIXED_OPTION = '<option  gravity="0 0 -5"\n   timestep = \'0.001\' integrator="implicitfast" />'
APPENDED = f"  <option {NEW}/>\n</mujoco>"
ROBOT = """<robot name="r">
  <link name="a"/><link name="b"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
{mujoco}</robot>
"""
EXTENDED = '  <mujoco><option timestep="0.01"/></mujoco>\n'
# name: (text of the file, text to replace, text in its place, place of the options)
TEXTS = {
    "own option": (
        ROD.format(head=OPTION, joint="", tail=""),
        OPTION,
        FIXED_OPTION,
        "own option",
    ),
    "no option": (ROD.format(head="", joint="", tail=""), "</mujoco>", APPENDED, "new option"),
    "two options": (
        ROD.format(head='<option timestep="1"/>', joint="", tail="<option integrator='RK4'/>"),
        """<option timestep="1"/>""",
        """<option timestep="0.001"/>""",
        "own option",
    ),
    "option before an include": (
        ROD.format(head=OPTION, joint="", tail='<include file="part.xml"/>'),
        "</mujoco>",
        APPENDED,
        "new option",
    ),
    "option after an include": (
        ROD.format(head='<include file="part.xml"/>' + OPTION, joint="", tail=""),
        OPTION,
        FIXED_OPTION,
        "own option",
    ),
    "urdf": (
        ROBOT.format(mujoco=""),
        "</robot>",
        f"  <mujoco><option {NEW}/></mujoco>\n</robot>",
        "new mujoco",
    ),
    "extended urdf": (
        ROBOT.format(mujoco=EXTENDED),
        '<option timestep="0.01"/>',
        f"<option {NEW}/>",
        "own option",
    ),
}
PART = '<mujoco><option timestep="0.03" integrator="RK4"/></mujoco>'


def options(path):
    """The step and the integrator of a file."""
    model = mujoco.MjModel.from_xml_path(str(path))
    return model.opt.timestep, mujoco.mjtIntegrator(model.opt.integrator).name


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("name", TEXTS)
def test_only_the_options_change(name, newline, tmp_path):
    text, old, new, place = TEXTS[name]
    (tmp_path / "part.xml").write_text(PART)
    suffix = ".urdf" if "urdf" in name else ".xml"
    source, target = tmp_path / f"my{suffix}", tmp_path / f"fixed{suffix}"
    source.write_text(text, "utf-8", newline=newline)
    assert write_fixed(source, FIX, target) == place
    assert options(target) == (0.001, "mjINT_IMPLICITFAST")
    expected = text.replace(old, new)
    if name == "two options":
        expected = expected.replace("'RK4'", "'implicitfast'")
    assert target.read_bytes() == expected.replace("\n", newline).encode()
    assert source.read_bytes() == text.replace("\n", newline).encode()
    assert not list(tmp_path.glob(".*"))


FLAGGED = '<option><flag warmstart="disable"/></option>'


@pytest.mark.parametrize(
    "head", ["", OPTION, FLAGGED, "<option timestep='1'><!-- a comment --></option>"]
)
@pytest.mark.parametrize("suffix", [".xml", ".urdf"])
def test_refsafe_is_disabled(head, suffix, tmp_path):
    source, target = tmp_path / f"my{suffix}", tmp_path / f"fixed{suffix}"
    text = ROD.format(head=head, joint="", tail="")
    if suffix == ".urdf":
        text = ROBOT.format(mujoco=f"<mujoco>{head}</mujoco>" if head else "")
    source.write_text(text)
    write_fixed(source, FileFix({"timestep": "0.02"}, True, (), 0.0), target)
    model = mujoco.MjModel.from_xml_path(str(target))
    off = model.opt.disableflags & ~int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
    assert off == mujoco.mjtDisableBit.mjDSBL_REFSAFE
    assert model.opt.timestep == 0.02


LIMITED = 'limited="true" range="0 1"'


@pytest.mark.parametrize("place", ["element", "class", "include", "built in"])
def test_time_constants_are_raised_where_they_stand(place, tmp_path):
    """At a step of 20 ms refsafe raises each of them to 40 ms, MuJoCo's own 20 ms too."""
    joint, head, part, numbers = LIMITED, '<option timestep="0.02"/>', PART, "0.01 0.7"
    if place == "element":
        joint += ' solreflimit="0.01 0.7"'
    elif place == "class":
        head = f'<default><joint solreflimit="0.01 0.7"/></default>{head}'
    elif place == "include":
        part = '<mujoco><default><joint solreflimit="0.01 0.7"/></default></mujoco>'
        head = f'<include file="part.xml"/>{head}'
    else:
        numbers = "0.02 1"
    (tmp_path / "part.xml").write_text(part)
    source, target = tmp_path / "my.xml", tmp_path / "fixed.xml"
    source.write_text(ROD.format(head=head, joint=joint, tail=""))
    write_fixed(source, FileFix({"timestep": "0.001"}, False, ("jnt_solref",), 0.04), target)
    before, after = (mujoco.MjModel.from_xml_path(str(path)) for path in (source, target))
    assert before.jnt_solref[0].tolist() == [float(number) for number in numbers.split()]
    assert after.jnt_solref[0].tolist() == [0.04, before.jnt_solref[0, 1]]
    assert after.opt.timestep == 0.001
    assert "<include" not in target.read_text()


def test_a_fix_that_the_text_cannot_take_is_refused(tmp_path):
    """A time constant of a flex has no default class; nothing is written."""
    source, target = tmp_path / "my.xml", tmp_path / "fixed.xml"
    flex = '<flexcomp name="f" type="grid" count="3 3 1" spacing=".1 .1 .1" mass="1" radius=".01"/>'
    source.write_text(f"<mujoco><worldbody>{flex}</worldbody></mujoco>")
    with pytest.raises(ParameterError, match="cannot be changed without flex_solref"):
        write_fixed(
            source, FileFix({"timestep": "1e-3"}, False, ("flex_solref",), 0.04), target
        )
    elsewhere = tmp_path / "other" / "fixed.xml"
    elsewhere.parent.mkdir()
    source.write_text(ROD.format(head='<include file="part.xml"/>', joint="", tail=""))
    (tmp_path / "part.xml").write_text(PART)
    with pytest.raises(ParameterError, match="beside the model"):
        write_fixed(source, FIX, elsewhere)
    assert sorted(path.name for path in tmp_path.rglob("*.xml")) == ["my.xml", "part.xml"]


SERVO = """<mujoco>
  <option timestep="0.002"/>  <!-- a comment -->
  <worldbody>
    <body><joint name="j" axis="0 1 0" damping="0.01"/>
      <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass="0.1"/></body>
  </worldbody>
  <actuator><position joint="j" kp="200" kv="1"/></actuator>
</mujoco>
"""
BOX = """<mujoco>
  <option timestep="0.005"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1"/>
    <body name="box" pos="0 0 0.0499"><freejoint/>
      <geom name="box" type="box" size=".1 .08 .05" friction=".3"/></body>
  </worldbody>
  <keyframe><key name="slide" qpos="0 0 .0499 1 0 0 0" qvel="1 0 0 0 0 0"/></keyframe>
</mujoco>
"""
WITH_INCLUDE = """<mujoco>
  <include file="servo.xml"/>
  <statistic extent="1"/>
</mujoco>
"""
SHOWN = {
    "servo": ["--ctrl", "sines", "--duration", "0.3"],
    "include": ["--ctrl", "sines", "--duration", "0.3"],
    "box": ["--keyframe", "slide", "--duration", "1"],
    "half_cheetah": ["--ctrl", "sines", "--duration", "1"],
}


def written(name, folder):
    """The file of this name in a folder."""
    texts = {"servo": SERVO, "box": BOX, "include": WITH_INCLUDE}
    (folder / "servo.xml").write_text(SERVO)
    if name == "half_cheetah":
        assets = pytest.importorskip("gymnasium").__path__[0] + "/envs/mujoco/assets"
        texts[name] = Path(assets, "half_cheetah.xml").read_text("utf-8")
    (folder / f"{name}.xml").write_text(texts[name])
    return folder / f"{name}.xml"


@pytest.mark.rare(keep=2)
@pytest.mark.long(keep=1)
@pytest.mark.parametrize("name", SHOWN)
def test_new_file_has_the_promised_error(name, tmp_path, monkeypatch, capsys):
    """The promised error is held to the uncertainty of the two references; the audit of a file with
    the old options would miss it by orders of magnitude."""
    monkeypatch.chdir(tmp_path)
    source = written(name, tmp_path)
    text = source.read_bytes()
    line = ["audit", source.name, *SHOWN[name], "--budget", "15", "--write-fixed", "fixed.xml"]
    assert main([*line, "--json"]) == 0
    fixed = json.loads(capsys.readouterr().out)["fixed_file"]
    assert fixed["kept"]
    assert abs(fixed["error"] - fixed["promised"]) <= fixed["uncertainty"] < 1e-5
    assert abs(fixed["before"] - fixed["promised"]) > 10 * fixed["uncertainty"]
    assert fixed["until"] == pytest.approx(float(SHOWN[name][-1]))
    assert source.read_bytes() == text
    new = tmp_path / "fixed.xml"
    for option, value in fixed["options"].items():
        assert f'{option}="{value}"' in new.read_text("utf-8")
    assert main(line) == 2
    assert (
        "write fixed = 'fixed.xml': must be a file that does not exist"
        in capsys.readouterr().err
    )


def hanging(folder):
    """The file of a pendulum that hangs still."""
    path = folder / "hanging.xml"
    path.write_text(ROD.format(head="", joint="", tail="").replace(".5 0 0", "0 0 -.5"))
    return path


def test_nothing_is_written_where_the_step_is_to_be_kept(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    hanging(tmp_path)
    line = [
        "audit",
        "hanging.xml",
        "--duration",
        "0.1",
        "--budget",
        "3",
        "--write-fixed",
        "new.xml",
    ]
    assert main(line) == 1
    printed = capsys.readouterr()
    assert "nothing moves under this control" in printed.out
    assert "new.xml is not written: nothing moves on this motion" in printed.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["hanging.xml"]


def test_a_compiled_model_has_no_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    spec = mujoco.MjSpec.from_string(SERVO)
    for model in (spec, spec.compile()):
        result = plumbob.audit(model, duration=0.1, budget=2.0)
        with pytest.raises(ParameterError, match="a compiled model has no text to change"):
            result.write_fixed("new.xml")
    mujoco.mj_saveModel(spec.compile(), "my.mjb", None)
    assert main(["audit", "my.mjb", "--write-fixed", "new.mjb"]) == 2
    assert not Path("new.xml").exists()


@pytest.mark.long
def test_from_python(tmp_path):
    source = written("servo", tmp_path)
    result = plumbob.audit(source, "sines", duration=0.1, budget=2.0)
    fixed = result.write_fixed(tmp_path / "new.xml", budget=2.0)
    assert fixed.kept
    assert fixed.audit.integrator == fixed.choice.integrator
    assert np.array_equal(fixed.audit.script.controls, result.script.controls)
    still = plumbob.audit(hanging(tmp_path), duration=0.1, budget=3.0)
    with pytest.raises(NothingToFix, match="nothing moves"):
        still.write_fixed(tmp_path / "other.xml")
