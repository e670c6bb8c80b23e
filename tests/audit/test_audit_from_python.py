"""The result of an audit from Python: a line, text, a card, plain data and plots."""

import json
import re
from dataclasses import replace
from html import unescape
from operator import attrgetter
from pathlib import Path

import mujoco
import pytest

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.reports.cli import main
from plumbob.reports.view.audit.results import ContactResult, MotionResult

ROD = """<mujoco><worldbody><body><joint name="hinge" axis="0 1 0"/><geom size=".1" pos=".5 0 0"/>
</body></worldbody><actuator><motor joint="hinge"/></actuator></mujoco>"""
BOX = """<mujoco><worldbody><geom name="floor" type="plane" size="9 9 1"/>
<body name="box" pos="0 0 .1"><freejoint/><geom type="box" size=".1 .2 .02"/></body>
</worldbody></mujoco>"""


@pytest.fixture(name="results", scope="module")
def _results(tmp_path_factory):
    file = tmp_path_factory.mktemp("robots") / "rod.xml"
    file.write_text(ROD, "utf-8")
    return {
        "rod.xml": plumbob.audit(file, duration=0.1, budget=5.0),
        "model": plumbob.audit_contacts(mujoco.MjModel.from_xml_string(BOX)),
    }


BOTH = pytest.mark.parametrize("name", ["rod.xml", "model"])


@BOTH
def test_a_line_a_text_and_a_card_say_the_same(results, name):
    result = results[name]
    text = result.text()
    html = unescape(result._repr_html_()).replace("\u00a0", " ")
    assert re.fullmatch(f"<audit of {name}: .+>", repr(result))
    (line,) = re.findall("<strong>(.*)</strong>", re.sub("</?span.*?>", "", html))
    assert repr(result) == f"<audit of {name}: {line}>"
    assert line.split(" wrong")[0].removeprefix("up to ") in text
    for row in text.splitlines():
        assert row.split(None, 1)[1] in html or row.split("  ", 1)[1].strip() in html
    assert "src=" not in html
    assert "<script" not in html


@BOTH
def test_what_is_documented_is_there(results, name):
    result = results[name]
    for attribute in re.findall(r"`([a-z_.]+\b)", type(result).__doc__ or ""):
        run = attribute in ("step", "distances", "drift", "turning")
        of = result.own[0] if run and isinstance(result, ContactResult) else result
        if not attribute.startswith("plumbob"):
            attrgetter(attribute)(of)
    if isinstance(result, ContactResult):
        assert result.own[0].distances.shape == result.errors(result.own[0]).shape == (16,)
        return
    assert isinstance(result, MotionResult)
    periods, actuators = result.script.controls.shape
    assert (periods, actuators) == (5, 1)
    corners = len(result.model.corner_bodies)
    assert result.reference.corners.shape == (periods + 1, corners, 3)
    assert [points.shape for points in result.corners.values()] == [(corners - 1, 3)]
    for samples in (
        result.script.times,
        result.reference.uncertainty,
        result.found.own.errors,
    ):
        assert samples.shape == (periods + 1,)
    assert {name: pose.shape for name, pose in result.pose.items()} == {
        "world": (3,),
        "body 1": (3,),
    }


def test_plain_data_are_what_the_command_prints(results, capsys):
    """Whatever is not timed is the same."""
    data = results["rod.xml"].to_dict()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    short = ["--duration", "0.1", "--budget", "5", "--json"]
    assert main(["audit", str(Path(data["model"])), *short]) == 0
    printed = json.loads(capsys.readouterr().out)
    timed = {"seconds", "steps", "cheapest", "trims", "to_do"}
    assert printed.keys() == data.keys()
    assert all(printed[key] == data[key] for key in data.keys() - timed)


def test_without_an_answer_the_line_says_why(results):
    motion = results["rod.xml"]
    contacts = results["model"]
    assert isinstance(motion, MotionResult)
    assert isinstance(contacts, ContactResult)
    lost = replace(motion, found=None, reference=replace(motion.reference, why="it blows up"))
    assert repr(lost) == "<audit of rod.xml: not certified: it blows up>"
    with pytest.raises(ParameterError, match="must be a figure of this audit: none"):
        lost.plot()
    unsettled = replace(contacts, own=(), failed=("own contacts: it never rests",))
    assert repr(unsettled) == "<audit of model: own contacts: it never rests>"
