"""Several models by one command: a row each, the largest error first, whatever one of them is."""

import json
import math
import os
import re
from dataclasses import replace
from functools import partial
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import pytest

from plumbob import audit
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.workers import Workers
from plumbob.reports.cli import main
from plumbob.reports.commands.shared import several_audits
from plumbob.reports.commands.shared.several_audits import (
    Row,
    model_files,
    page_names,
    refused_row,
    write_badge,
)

ROD = """<mujoco><option timestep="{step}"/><worldbody><body><joint axis="0 1 0"/>
<geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>"""
QUICK = ["--duration", "0.1", "--budget", "5", "--jobs"]


@pytest.fixture
def folder(tmp_path):
    """Two rods of one name, one with ten times the step; a broken file; one that includes another;
    and one that is no model."""
    for place, step in (("fine", 1e-3), ("coarse", 1e-2)):
        (tmp_path / place).mkdir()
        (tmp_path / place / "rod.xml").write_text(ROD.format(step=step))
    (tmp_path / "broken.xml").write_text("<mujoco><no_such_element/></mujoco>")
    (tmp_path / "whole.xml").write_text('<mujoco><include file="part.xml"/></mujoco>')
    (tmp_path / "part.xml").write_text(ROD.format(step=2e-3))
    (tmp_path / "notes.xml").write_text("<notes/>")
    return tmp_path


def test_which_files_are_meant(folder):
    """A single file is none of several; a folder gives what no other file there includes."""
    rod = str(folder / "fine" / "rod.xml")
    assert model_files([rod]) == (None, [])
    assert model_files([rod, rod]) == ([Path(rod)], [])
    files, others = model_files([str(folder)])
    assert others == [folder / "notes.xml"]
    inside = {path.relative_to(folder).as_posix() for path in files}
    assert inside == {"fine/rod.xml", "coarse/rod.xml", "broken.xml", "whole.xml"}
    assert model_files([str(folder / "*" / "rod.xml")])[0] == [
        folder / "coarse" / "rod.xml",
        folder / "fine" / "rod.xml",
    ]
    for nothing in (str(folder / "*.mjcf"), str(folder / "empty")):
        (folder / "empty").mkdir(exist_ok=True)
        with pytest.raises(ParameterError, match="a file, or a folder or pattern with models"):
            model_files([nothing])


NO_MODELS = {
    "assets.xml": "<mujoco><!-- <worldbody/> --><compiler/><asset/><default/></mujoco>",
    "package.xml": "<package><export><mujoco plugin='a'/></export></package>",
    "part.xml": "<mujocoinclude><worldbody/></mujocoinclude>",
}


def test_what_is_no_model_is_skipped_and_counted(tmp_path, monkeypatch, capsys):
    """And what is no file, or cannot be read, costs its row."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rod.xml").write_text(ROD.format(step=1e-3))
    for name, text in NO_MODELS.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "folder.xml").mkdir()
    os.mkfifo("pipe.xml")
    Path("dangling.xml").symlink_to("nothing.xml")
    Path("loop.xml").symlink_to("loop.xml")
    Path("inside").symlink_to(tmp_path)
    audits = [Row(str(tmp_path), 1.0, 1.0, "", 0, {})]
    asked = []
    monkeypatch.setattr(
        several_audits, "audit_rows", lambda files, *rest: asked.extend(files) or audits
    )
    assert main(["audit", "."]) == 0
    assert capsys.readouterr().err == (
        "plumbob: 3 files are no models and are skipped, such as assets.xml\n"
        f"plumbob: 1 of 5: {tmp_path} audited\n"
    )
    odd = {"folder.xml", "pipe.xml", "dangling.xml", "loop.xml"}
    assert {str(path) for path in asked} == {"rod.xml", *odd}
    files, others = model_files([*NO_MODELS, "rod.xml"], models_only=True)
    assert (files, others) == ([Path("rod.xml")], list(map(Path, NO_MODELS)))
    assert model_files(["rod.xml"], models_only=True) == (None, [])
    assert main(["audit", "--models-only", "--json", "package.xml"]) == 0
    assert capsys.readouterr().out == "[]\n"


@pytest.mark.parametrize("kind", ["folder", "pipe", "link"])
def test_what_is_no_file_has_a_row_that_says_so(kind, tmp_path, monkeypatch):
    path = tmp_path / "odd.xml"
    {"folder": path.mkdir, "pipe": partial(os.mkfifo, path)}.get(
        kind, partial(path.symlink_to, tmp_path / "nothing")
    )()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ParameterError, match=r"odd\.xml"):
        audit(path)


def test_the_largest_file_is_begun_first(folder, monkeypatch):
    """And one that is not there is the smallest."""
    begun = []
    monkeypatch.setattr(Workers, "results", lambda self, tasks: begun.extend(tasks) or ())
    files = [folder / name for name in ("none.xml", "notes.xml", "part.xml", "whole.xml")]
    assert list(several_audits.audit_rows(files, str, 2, 1.0)) == []
    assert [task.key.stem for task in begun] == ["part", "whole", "notes", "none"]


HOSTILE = "a b&#?%\x1b\x00\udcff\ud800\u2028'<:é.xml"


def test_names_with_any_character(tmp_path):
    """JUnit's file is XML, and a link leads to the page's file."""
    name = HOSTILE.replace("\x00", "").replace("\ud800", "")
    row = replace(refused_row(name, HOSTILE), page=f"audit-{name}.html".replace(".xml", ""))
    page = several_audits.write_page([row], tmp_path, HOSTILE, 1.0)
    (tmp_path / row.page).touch()
    links = re.findall(r'href="(audit-[^"]*)"', page.read_text("utf-8"))
    (file,) = [unquote(link, errors="surrogateescape") for link in links]
    assert (page.parent / file).exists()
    assert not set(links[0]) & set(" #?<':\x1b")
    several_audits.write_junit(tmp_path / "junit.xml", [row, replace(row, missed=HOSTILE)], 0.0)
    suite = ElementTree.parse(tmp_path / "junit.xml").getroot()
    case = suite.find("testcase")
    assert case.attrib["name"].startswith("a b&#?%\\x1b\\udcff")
    assert "\\x00" in case.find("error").attrib["message"]


def test_each_file_has_a_page_of_its_own():
    """Also beside one whose path reads the same, and beside the table's."""
    assert page_names([Path("a/b-c.xml"), Path("a/b/c.xml"), Path("a/models.xml")]) == {
        "a/b-c.xml": "audit-b-c",
        "a/b/c.xml": "audit-b-c-2",
        "a/models.xml": "audit-models-2",
    }


def test_a_path_ends_no_workflow_command():
    """A line break, a comma or a colon in it."""
    (command,) = several_audits.workflow_commands(refused_row("a\n::b,c.xml", "no\nmodel"))
    assert command == "::error file=a%0A%3A%3Ab%2Cc.xml,line=1,title=plumbob audit::no%0Amodel"


@pytest.mark.long
def test_a_broken_model_costs_its_row(folder, capsys):
    out = folder / "out"
    given = [str(folder / name) for name in ("broken.xml", "fine", "coarse")]
    assert main(["audit", *given, *QUICK, "2", "--out", str(out)]) == 2
    head, *table = capsys.readouterr().out.splitlines()
    assert head.split()[:3] == ["model", "step", "error"]
    assert [line.split()[0] for line in table] == [
        "coarse/rod.xml",
        "fine/rod.xml",
        "broken.xml",
    ]
    assert "must be a MuJoCo model file" in table[-1]
    pages = {page.name for page in out.glob("*.html")}
    assert pages == {"audit-models.html", "audit-fine-rod.html", "audit-coarse-rod.html"}
    text = (out / "audit-models.html").read_text("utf-8")
    assert all(f'<a href="{page}"' in text for page in pages - {"audit-models.html"})
    assert "broken.xml" in text


@pytest.mark.long
def test_json_is_a_list_of_what_one_audit_gives(folder, capsys):
    fine, coarse = (str(folder / place / "rod.xml") for place in ("fine", "coarse"))
    assert main(["audit", fine, *QUICK, "1", "--json"]) == 0
    alone = json.loads(capsys.readouterr().out)
    asked = ["--absolute", str(2.0 * alone["error"])]
    # the coarse one misses it
    assert (
        main(["audit", str(folder / "f*" / "rod.xml"), coarse, *QUICK, "1", *asked, "--json"])
        == 1
    )
    both = json.loads(capsys.readouterr().out)
    assert [one["path"] for one in both] == [coarse, fine]
    assert set(both[1]) == {*alone, "path"}
    known = both[1]["uncertainty"] + alone["uncertainty"]
    assert both[1]["error"] == pytest.approx(alone["error"], abs=known)


def test_junit_has_a_case_for_each_model(folder, capsys, monkeypatch):
    """Passing, missing what is asked for, without a reference, and refused."""
    of = {
        "a.xml": Row("a.xml", 0.1, 0.01, "keep", 0, {"error": 0.1, "uncertainty": math.inf}),
        "b.xml": Row("b.xml", 0.3, 0.01, "keep", 1, {"error": 0.3}, missed="0.3 m off"),
        "c.xml": Row("c.xml", None, 0.01, "", 0, {"error": math.nan, "why": "a chaos"}),
        "d.xml": refused_row("d.xml", "no model"),
    }
    monkeypatch.setattr(
        "plumbob.reports.commands.shared.several_audits.audit_rows",
        lambda *_: iter(of.values()),
    )
    junit = folder / "new" / "junit.xml"
    assert main(["audit", str(folder), "--junitxml", str(junit)]) == 2
    suite = ElementTree.parse(junit).getroot()
    counts = [suite.get(name) for name in ("tests", "failures", "errors", "skipped")]
    assert counts == ["4", "1", "1", "1"]
    said = {case.get("name"): case.find("*[@message]") for case in suite}
    assert said["a.xml"] is None
    outcomes = {name: (e.tag, e.get("message")) for name, e in said.items() if e is not None}
    assert outcomes == {
        "b.xml": ("failure", "0.3 m off"),
        "c.xml": ("skipped", "no reference: a chaos"),
        "d.xml": ("error", "no model"),
    }
    held = suite.findall("testcase[@name='a.xml']/properties/property")
    assert {p.get("name"): p.get("value") for p in held} == {"error": "0.1"}
    assert "0.3 m off" in capsys.readouterr().err


SMALL = Row("a.xml", 0.035, 0.01, "keep", 0, {})
FINE = replace(SMALL, error=1e-6, data={"resolved": False, "uncertainty": 2e-6})


def test_an_error_below_the_certificate_is_a_bound():
    _, fine, small = several_audits.table_lines([FINE, SMALL])
    assert "at most 3 µm" in fine
    assert "at most" not in small


@pytest.mark.parametrize(
    ("rows", "bounded", "message", "color"),
    [
        ([SMALL], False, "3.5 cm", "blue"),
        ([SMALL], True, "3.5 cm", "brightgreen"),
        ([replace(SMALL, code=1, missed="3.5 cm off")], True, "3.5 cm", "red"),
        ([FINE], False, "at most 3 µm", "blue"),
        ([FINE, SMALL], True, "3.5 cm, worst of 2 models", "brightgreen"),
        ([replace(SMALL, error=math.inf)], False, "diverges", "blue"),
        ([replace(SMALL, error=None)], True, "no reference", "lightgrey"),
        ([SMALL, replace(SMALL, error=None)], False, "3.5 cm, worst of 2 models", "lightgrey"),
        ([replace(SMALL, error=None, code=1, missed="none")], False, "no reference", "red"),
        ([refused_row("d.xml", "no model")], False, "not audited", "red"),
        ([SMALL, refused_row("d.xml", "no model")], True, "3.5 cm, worst of 2 models", "red"),
    ],
)
def test_a_badge_says_the_largest_error(rows, bounded, message, color, tmp_path):
    write_badge(tmp_path / "badge.json", rows, bounded)
    badge = json.loads((tmp_path / "badge.json").read_text("utf-8"))
    label = {"schemaVersion": 1, "label": "simulation error"}
    assert badge == {**label, "message": message, "color": color}
