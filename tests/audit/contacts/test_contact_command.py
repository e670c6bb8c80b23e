"""plumbob audit --contacts: what it prints and writes, and what it refuses by name."""

import json
from pathlib import Path

import pytest

from plumbob.engines.abilities import UserModels
from plumbob.engines.adapters.mujoco import ENGINE
from plumbob.engines.own_motion import Start
from plumbob.reports.cli import main
from plumbob.tests.audit.contacts.bodies_on_planes import (
    FLOOR,
    audited_once,
    model_text,
    texts,
)
from plumbob.tests.audit.scenes_as_models import compiled

BOX = '<geom name="box" type="box" size=".1 .2 .02"/>'


@pytest.fixture(name="found", scope="module")
def _found():
    return audited_once(texts()["four-footed box"])


LOAD = (
    '<body name="load" pos="0 0 {z}"><freejoint/><geom name="load" size=".1"/><site name="l"/>'
    "</body>"
)
HOOK = '<site name="hook" pos="0 0 2"/>'
LEFT_OUT = (  # said, more in the world, more behind it
    (
        "other constraints and contacts",
        LOAD.format(z=3),
        '<equality><weld body1="base" body2="load"/></equality>',
    ),
    (
        "other constraints and contacts",
        LOAD.format(z=3),
        '<equality><connect site1="l" site2="s"/></equality>',
    ),
    ("other constraints and contacts", LOAD.format(z=0.139), ""),
    (
        "passive forces",
        HOOK,
        '<tendon><spatial stiffness="9" springlength="1"><site site="s"/><site site="hook"/>'
        "</spatial></tendon>",
    ),
    (
        "forces of actuators",
        "",
        '<actuator><motor name="thrust" site="s" gear="1 0 0 0 0 0"/></actuator>'
        '<keyframe><key ctrl="1"/></keyframe>',
    ),
    (
        "forces of actuators",
        "",
        '<actuator><adhesion name="magnet" body="base" ctrlrange="0 1" gain="9"/></actuator>'
        '<keyframe><key ctrl="1"/></keyframe>',
    ),
    (
        "",
        LOAD.format(z=3),
        '<equality><weld body1="base" body2="load" active="false"/></equality>'
        '<actuator><motor name="thrust" site="s" gear="1 0 0 0 0 0"/></actuator>',
    ),
)


def _contacts(model, keyframe=None, body=None):
    models = ENGINE.ability(UserModels)
    return models.contacts(model, Start(keyframe), body, None)


@pytest.mark.parametrize(("said", "world", "more"), LEFT_OUT)
def test_what_acts_on_the_body_and_is_left_out_is_said(said, world, more):
    text = model_text(BOX + '<site name="s"/>', 0.02, floor=FLOOR + world, more=more)
    model = compiled(text)
    contacts = _contacts(model, 0 if model.nkey else None, "base")
    assert "; ".join(contacts.notes) == said


@pytest.mark.long
def test_command_prints_and_writes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("box.xml").write_text(texts()["four-footed box"], "utf-8")
    assert main(["audit", "box.xml", "--contacts", "--json", "--out", "pages"]) == 0
    printed = capsys.readouterr()
    assert printed.err.strip() == "pages/audit-box-contacts.html"
    data = json.loads(printed.out)
    assert data["distance"] == pytest.approx(0.5**2 / (2 * 0.3 * 9.81))
    assert len(data["own"]) == len(data["pasted"]) == 4
    assert max(map(abs, data["own"][0]["errors"])) > 0.01
    assert max(map(abs, data["pasted"][0]["errors"])) < 0.001
    page = Path("pages/audit-box-contacts.html").read_text("utf-8")
    assert "plumbob audit box.xml --contacts --json --out pages" in page
    assert main(["audit", "box.xml", "--contacts", "--speed", "1", "--absolute", "0.01"]) == 1
    printed = capsys.readouterr()
    assert "from 1 m/s at 16 headings" in printed.out
    assert "the stopping distance at 1 m/s is" in printed.err


@pytest.mark.long
def test_settings_pasted_into_the_file_give_what_is_said(found):
    """The file with the snippet in it, read anew, is its own contact audit's pasted result."""
    text = texts()["four-footed box"]
    option = '<option timestep="0.002"/>'
    assert option in text
    pasted = audited_once(text.replace(option, found.snippet))
    own = pasted.own[0].distances
    there = found.pasted[0].distances
    assert own == pytest.approx(there, rel=1e-6)


UNNAMED = """<mujoco><option timestep="0.002"/><worldbody><geom type="plane" size="9 9 1"/>
  <body name="b--x" pos="0 0 .05"><freejoint/><geom type="box" size=".1 .2 .05"/>
    <geom name="a&lt;b" type="box" size=".1 .2 .04" pos=".01 0 -.01"/></body>
</worldbody></mujoco>"""


def test_a_snippet_compiles_where_geoms_have_no_names():
    """The snippet says which names the geoms have to get first; with these it compiles."""
    contacts = _contacts(compiled(UNNAMED))
    snippet = contacts.snippet()
    assert 'first name these geoms: name="floor_1" for geom 0 of body world' in snippet
    text = UNNAMED.replace("<option", f"{snippet}<option")
    with pytest.raises(ValueError, match="floor_1"):
        compiled(text)
    text = text.replace('<geom type="plane"', '<geom name="floor_1" type="plane"')
    text = text.replace('<geom type="box"', '<geom name="foot_1" type="box"')
    assert compiled(text).npair == 2
