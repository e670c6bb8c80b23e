"""plumbob audit --holds: what it prints and writes, its exit codes, and what it refuses by name."""

import json

import mujoco
import pytest

from plumbob.reports.cli import main

BOX = '<geom type="box" size=".1 .1 .05" mass="1"/>'
FLOOR = '<geom name="floor" type="plane" size="9 9 1" friction="{friction}" euler="0 15 0"/>'
RESTING = '<body name="box" pos="0.01294 0 0.0483" euler="0 15 0"><freejoint/>{box}</body>'
# Position servos carry a trunk only after they have given way; a weld holds the hand by a mocap.
LEGS = """<mujoco><worldbody><geom type="plane" size="2 2 .1" euler="0 5 0"/>
<body name="trunk" pos="0 0 .32" euler="0 5 0"><freejoint/>
<geom type="box" size=".2 .1 .03" mass="5"/>{legs}</body></worldbody>
<actuator>{servos}</actuator></mujoco>"""
LEG = """<body pos="{x} {y} 0"><joint name="j{n}" type="slide" axis="0 0 1" damping="20"/>
<geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02" mass=".3"/></body>"""
HAND = """<mujoco><option cone="elliptic" impratio="10"/><worldbody>
<body name="hand" mocap="true" pos="0 0 .2"/>
<body name="palm" pos="0 0 .2"><freejoint/><geom type="box" size=".08 .02 .01" mass=".5"/>
{fingers}</body>
<body name="rod" pos="0 0 .12"><freejoint/><geom type="box" size=".04 .01 .01" mass=".2"/></body>
</worldbody><equality><weld body1="hand" body2="palm"/></equality>
<actuator><position joint="l" kp="10"/><position joint="r" kp="10"/></actuator>
<keyframe><key name="grip" ctrl="-.05 .05"/></keyframe></mujoco>"""
FINGER = """<body pos="{x} 0 -.06"><joint name="{name}" axis="0 1 0" pos="0 0 .04" damping=".1"/>
<geom type="box" size=".01 .02 .04" mass=".1"/></body>"""


def model(tmp_path, text, name="my.xml"):
    """Writes a model file, and returns its name."""
    (tmp_path / name).write_text(text)
    return str(tmp_path / name)


def ramp(tmp_path, friction=0.6):
    """A box on a slope of 15 degrees, whose tangent is 0.268."""
    box = BOX.replace("mass", f'friction="{friction}" mass')
    inside = FLOOR.format(friction=friction) + RESTING.format(box=box)
    return model(tmp_path, f"<mujoco><worldbody>{inside}</worldbody></mujoco>")


def test_a_ramp_holds_and_creeps_and_its_paste_stops_that(tmp_path, capsys):
    file = ramp(tmp_path)
    assert main(["audit", file, "--holds", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["holds"]
    assert found["coulomb"] == "holds"
    assert found["margin"] == pytest.approx(1.0 - 0.2679 / 0.6, abs=1e-3)
    # 0.92 mm/s, as the theory of `incline` says
    assert found["creep"] == pytest.approx(9.243e-4, rel=1e-3)
    assert found["predicted_creep"] == pytest.approx(found["creep"], rel=1e-3)
    assert found["distances"] == pytest.approx([9.243e-4, 5.546e-2], rel=1e-3)
    mujoco.MjModel.from_xml_string(f"<mujoco>{found['to_paste']}</mujoco>")
    assert found["tried"][-1]["creep"] <= found["wanted_creep"] == 1e-5


def test_the_lines_name_what_matters(tmp_path, capsys):
    assert main(["audit", ramp(tmp_path), "--holds", "--out", str(tmp_path / "out")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [
        "my.xml",
        "Coulomb",
        "engine",
        "paste",
        "not",
    ]
    assert '<option cone="elliptic" impratio="100"/>' in lines[3]
    assert main(["audit", ramp(tmp_path), "--holds", "--github"]) == 0
    assert "title=plumbob audit::Coulomb" in capsys.readouterr().err
    page = (tmp_path / "out" / "audit-my-holds.html").read_text()
    assert "impratio=&#34;100&#34;" in page or 'impratio="100"' in page


@pytest.mark.parametrize(
    ("friction", "more", "code", "said"),
    [
        (0.2, (), 1, "friction cannot hold box"),
        (1e-5, (), 1, "friction cannot hold box"),
        (0.6, ("--creep-within", "1e-4"), 1, "creeps at 0.000924 m/s"),
        (0.6, ("--creep-within", "1e-2"), 0, ""),
    ],
)
def test_the_exit_code_is_1_where_friction_cannot_hold_or_creep_is_too_fast(
    tmp_path, capsys, friction, more, code, said
):
    assert main(["audit", ramp(tmp_path, friction), "--holds", *more]) == code
    printed = capsys.readouterr()
    assert said in printed.err
    assert ("times the friction would not do either" in printed.out) == (friction < 1e-3)


@pytest.mark.parametrize(
    ("inside", "more", "said"),
    [
        (RESTING.format(box=BOX), ("--holds-body", "ball"), "a body that can move: box"),
        (f"<body>{BOX}</body>", (), "no body can move"),
        (f'<body pos="0 0 9"><joint/>{BOX}</body>', (), "touches anything"),
        (RESTING.format(box=BOX), ("--holds-body", "world"), "a body that can move: box"),
        (f'<body gravcomp="1e308"><freejoint/>{BOX}</body>', (), "not a number"),
        (RESTING.format(box=BOX), ("--creep-within", "-1"), "creep-within = -1"),
        (RESTING.format(box=BOX), ("--contacts",), "left out with --contacts"),
        (RESTING.format(box=BOX), ("--duration", "2"), "left out with --holds"),
        (RESTING.format(box=BOX), ("--absolute", "2"), "left out with --holds"),
        (RESTING.format(box=BOX), ("--badge", "b.json"), "left out with --holds"),
        (RESTING.format(box=BOX), ("--csv",), "left out with --holds"),
    ],
)
def test_bad_input_is_named_with_code_2(tmp_path, capsys, inside, more, said):
    text = f"<mujoco><worldbody>{FLOOR.format(friction=0.6)}{inside}</worldbody></mujoco>"
    assert main(["audit", model(tmp_path, text), "--holds", *more]) == 2
    assert said in " ".join(capsys.readouterr().err.split())


def test_holds_body_and_creep_within_are_given_with_holds(tmp_path, capsys):
    assert main(["audit", ramp(tmp_path), "--holds-body", "box"]) == 2
    assert "given with --holds" in capsys.readouterr().err


def test_servos_on_a_slope_hold_where_they_have_settled(tmp_path, capsys):
    corners = [(x, y) for x in (-0.15, 0.15) for y in (-0.1, 0.1)]
    legs = "".join(LEG.format(x=x, y=y, n=n) for n, (x, y) in enumerate(corners))
    servos = "".join(f'<position joint="j{n}" kp="2000"/>' for n in range(4))
    file = model(tmp_path, LEGS.format(legs=legs, servos=servos))
    assert main(["audit", file, "--holds", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["holds"]
    assert (found["coulomb"], found["judged_at"]) == ("holds", "settled")
    assert found["predicted_creep"] == pytest.approx(found["creep"], rel=0.05)


def test_a_hand_on_a_mocap_holds_a_rod_with_fingers_on_hinges(tmp_path, capsys):
    fingers = FINGER.format(x=-0.05, name="l") + FINGER.format(x=0.05, name="r")
    file = model(tmp_path, HAND.format(fingers=fingers))
    assert main(["audit", file, "--holds", "--holds-body", "rod", "--keyframe", "grip"]) == 0
    lines = capsys.readouterr().out
    assert "Coulomb      holds" in lines
    assert "of the actuators' forces is enough" in lines
