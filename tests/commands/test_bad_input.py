"""Bad input that once ended in a traceback or a hang: one line, exit code 2, nothing written."""

import os
import re
import shlex
import tomllib
from argparse import ArgumentParser
from contextlib import chdir
from dataclasses import replace
from pathlib import Path

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import method
from plumbob.engines.study import store
from plumbob.reports.cli import COMMANDS, main
from plumbob.reports.commands.arguments import options
from plumbob.tests.commands.test_cli import ran
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import made_up, quick

MOST = 700  # characters of a line, with a value of 200: a few lines of a terminal
REFUSED = tomllib.loads(Path(__file__).with_name("refused.toml").read_text("utf-8"))
ODD = {  # what stands for them in that file
    "DEEP": "[" * 100_000,
    "OBJECT": '{"a":' * 100_000,
    "NESTED": "[" * 900 + "]" * 900,
    "BYTE": os.fsdecode(b"\xff"),
}
BALL = """<mujoco><option timestep="{}"/><worldbody><geom type="plane" size="1 1 1"/>
<body pos="0 0 0.1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"""
FILES = {
    "file": "in the way",
    "notes.xml": "notes",
    "robot.xml": '<robot name="a"><link name="b"/></robot>',
    "condim.xml": '<mujoco><default><geom condim="2"/></default></mujoco>',
    "encoding.xml": '<?xml version="1.0" encoding="klingon"?><mujoco/>',
    "infinite.xml": BALL.format("inf"),
    "short.xml": BALL.format("1e-300"),
    "long.xml": BALL.format("1e300"),
    "ball.xml": BALL.format("1e-3"),
    "pairs.xml": """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
<geom name="ice" type="plane" size="1 1 1" condim="1"/><body pos="0 0 .1"><freejoint/>
<geom name="ball" size=".1"/><geom name="pearl" size=".1" condim="1"/></body></worldbody>
</mujoco>""",
    "heavy.xml": """<mujoco><option gravity="0 0 -1e300"/><worldbody>
<geom name="floor" type="plane" size="1 1 1"/><body><freejoint/><geom name="ball" size=".1"/></body>
</worldbody></mujoco>""",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With files of every kind but the right one, and a small stored study."""
    made = tmp_path_factory.mktemp("inputs")
    with chdir(made):
        _fill(made)
    return made


def _fill(made):
    for folder in (
        "out",
        "with-pipes",
        "pipes/cone_pendulum",
        "links/cone_pendulum",
        "folders",
    ):
        Path(folder).mkdir(parents=True)
    for folder in ("folder.html", "folder.xml"):
        Path(folder).mkdir()
    model = "cone_pendulum/cone_pendulum.xml"
    for pipe in ("pipe", "with-pipes/index.html", f"with-pipes/{store.FILE}", f"pipes/{model}"):
        os.mkfifo(pipe)
    for link in ("dangling", f"links/{model}", "folders/cone_pendulum"):
        Path(link).symlink_to(made / "nowhere")
    with Path("huge.xml").open("wb") as huge:
        huge.truncate(200_000_000)
    for name, text in FILES.items():
        Path(name).write_text(text, "utf-8")
    Path("stored").mkdir()
    study = made_up([(method("ode/rk4"), (1e-2, 1e-3), lambda step: step**4)])
    save(study, Path("stored") / store.FILE)


@pytest.fixture
def inputs(folder, monkeypatch):
    """The same as the working folder of a test that writes nothing into it."""
    monkeypatch.chdir(folder)
    return folder


@pytest.mark.parametrize("line", REFUSED)
def test_it_is_one_line_and_nothing_is_written(line, inputs, capsys):
    begin = REFUSED[line]
    words = shlex.split(line)
    for name, value in ODD.items():
        words = [word.replace(name, value) for word in words]
    before = sorted(inputs.rglob("*"))
    code, out, err = ran(capsys, *words)
    assert (code, out, err.count("\n")) == (2, "", 1), err
    # The command is named if its options are wrong.
    _, said = re.split(rf"^plumbob(?: (?:{'|'.join(COMMANDS)}))?: ", err)
    assert said.startswith(begin)
    assert len(err) < MOST, err
    assert sorted(inputs.rglob("*")) == before


RUN = ("--step", "1e-3", "--set")


@pytest.mark.parametrize(
    ("scene", "change", "verdict"),
    [
        ("capsule-coast", "friction=1e300", "diverged"),
        ("capsule-coast", "velocity_x=1e20", "diverged"),
        ("capsule-coast", "gravity=1e20", "unsupported (at this step the body tips over"),
        ("capsule-line", "inertia=1e-20", "unsupported (MuJoCo refuses the model"),
    ],
)
def test_a_run_that_cannot_begin_is_a_verdict(scene, change, verdict, capsys):
    assert main(("run", scene, "mujoco/euler+coulomb", *RUN, change)) == 1
    out, err = capsys.readouterr()
    assert f" at 0.001: {verdict}" in out
    assert err == ""


def test_a_finding_whose_numbers_a_store_lacks_is_left_out_and_the_page_says_so(
    tmp_path, capsys
):
    """As one of another version, whose templates asked for other numbers."""
    (old,) = [a for a in quick().analyses if a.template == "cone_pendulum/equilibria"]
    lacking = replace(old, numbers={n: v for n, v in old.numbers.items() if n != "fork"})
    analyses = tuple(lacking if a is old else a for a in quick().analyses)
    save(replace(quick(), analyses=analyses), tmp_path / store.FILE)
    assert main(["report", str(tmp_path)]) == 0
    assert capsys.readouterr().err == ""
    (page,) = tmp_path.glob("pages/cone-pendulum.html")
    text = page.read_text("utf-8")
    assert "Not shown by this study: 1 of the findings" in text
    assert "cone_pendulum/equilibria (&#39;fork&#39; is undefined)" in text
    assert "Two equilibria become four" not in text


def test_an_argument_with_two_names_is_refused_by_its_long_name(tmp_path, monkeypatch):
    (tmp_path / "shared.toml").write_text("", "utf-8")
    text = 'examples = []\n["-n --number"]\nkind = "number"\n'
    (tmp_path / "tried.toml").write_text(text, "utf-8")
    monkeypatch.setattr(options, "OPTIONS", tmp_path)
    parser = ArgumentParser()
    options.declare(parser, "tried", options)
    with pytest.raises(ParameterError) as refused:
        options.read_values(parser.parse_args(["-n", "one"]))
    assert refused.value.name == "number"
