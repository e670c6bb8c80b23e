"""Models that are no MJCF text: URDF, as MuJoCo's importer reads it, and compiled ones."""

import json
import re

import mujoco
import pytest

from plumbob import audit
from plumbob.reports.cli import main

INERTIAL = """<inertial><origin xyz="0 0 -.5"/><mass value="2"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>"""
TAKEN = (
    '<dynamics damping="0.3" friction="0.1"/>',
    ' effort="3"',
    '<mimic joint="shoulder" multiplier="2"/>',
)
LEFT = {
    "velocity limits": ' velocity="2"',
    "soft limits": '<safety_controller k_velocity="1"/>',
    "calibration": '<calibration rising="0"/>',
    "transmissions": '<transmission name="t"><joint name="shoulder"/></transmission>',
    "gazebo": '<gazebo reference="arm"><mu1>0.5</mu1></gazebo>',
}
ROBOT = f"""<robot name="r"><link name="base"/><link name="arm">{INERTIAL}</link>
<link name="hand">{INERTIAL}</link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1"{TAKEN[1]}{LEFT["velocity limits"]}/>
{TAKEN[0]}{LEFT["soft limits"]}{LEFT["calibration"]}</joint>
<joint name="wrist" type="continuous"><parent link="arm"/><child link="hand"/>
<axis xyz="0 1 0"/>{TAKEN[2]}</joint>{LEFT["transmissions"]}{LEFT["gazebo"]}</robot>"""


@pytest.mark.long
@pytest.mark.parametrize("suffix", [".urdf", ".mjb"])
def test_a_robot_of_another_format_is_audited_as_its_compiled_model(suffix, tmp_path, capsys):
    text = re.sub("<mimic[^>]*>", "", ROBOT)
    file = tmp_path / f"robot{suffix}"
    (tmp_path / "robot.urdf").write_text(text)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.urdf"))
    if suffix == ".mjb":
        mujoco.mj_saveModel(model, str(file), None)
    start = [0.5, 0.2]
    expected = audit(model, qpos=start, duration=0.1, budget=5.0)
    words = ["--qpos=0.5,0.2", "--duration", "0.1", "--budget", "5", "--json"]
    assert main(["audit", str(file), *words]) == 0
    data = json.loads(capsys.readouterr().out)
    assert any("URDF, read without velocity" in n for n in data["notes"]) == (suffix == ".urdf")
    known = data["uncertainty"] + expected.uncertainty
    assert data["error"] == pytest.approx(expected.error, abs=known)
    assert known < 0.1 * data["error"]
    assert main(["audit", str(file), "--write-trimmed", str(tmp_path / "new.xml")]) == 2
