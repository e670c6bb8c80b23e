"""The page of an audit stands alone, says what the text says, and is drawn from what was found."""

import json
import re
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import pytest

from plumbob.reports.cli import main
from plumbob.reports.view.audit.page import answer_rows, audit_answer, card_lines, page
from plumbob.reports.view.notation import metres
from plumbob.tests.audit.scenes_as_models import PENDULUM, audit_of, ball


@pytest.fixture(name="found", scope="module")
def _found():
    return audit_of(ball(0.12), duration=0.2)


@pytest.mark.long
def test_the_card_says_the_error_the_choice_and_the_certificate(found):
    """Its lines are MJCF that sets what the row of what to do says."""
    said, *change = card_lines(found)
    lines = dict(answer_rows(audit_answer(found)))
    error, choice, known = said.split(" · ")
    assert error == f"{lines['your error'].partition(' (')[0]} wrong after 0.2 s"
    assert known == f"certified to ±{metres(found.uncertainty)}"
    options = ElementTree.fromstring("\n".join(change)).attrib
    assert options
    for name, value in options.items():
        assert f"{name} {value}" in choice
        assert f'{name}="{value}" in place of ' in lines["to do"]
    shown = unescape(re.sub("<[^>]+>", "", page(audit_answer(found), found, "")))
    assert said in shown.replace("\u00a0", " ")


@pytest.mark.long
def test_command_writes_the_page_and_names_the_model_as_it_was_given(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    Path("arm").mkdir()
    Path("arm/rod.xml").write_text(PENDULUM.format(integrator="Euler"), "utf-8")
    short = ["audit", "arm/rod.xml", "--duration", "0.1", "--budget", "1"]
    assert main([*short, "--out", "pages"]) == 0
    printed = capsys.readouterr()
    assert printed.err.strip() == "pages/audit-rod.html"
    assert printed.out.startswith("rod.xml ")
    page = Path("pages/audit-rod.html").read_text("utf-8")
    assert "plumbob audit arm/rod.xml --duration 0.1" in page
    assert main([*short, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["model"] == "arm/rod.xml"
    assert main([*short, "--out", "arm/rod.xml"]) == 2
    assert capsys.readouterr().err.startswith("plumbob: out = 'arm/rod.xml'")
