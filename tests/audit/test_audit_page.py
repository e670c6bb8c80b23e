"""The page of an audit stands alone, says what the text says, and is drawn from what was found."""

import base64
import json
import re
import zlib
from html import unescape
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model import picture as picture_module
from plumbob.engines.audit.controls import script
from plumbob.engines.own_motion import Touching
from plumbob.reports.cli import main
from plumbob.reports.view.audit.page import answered, card, page, rows
from plumbob.reports.view.notation import metres
from plumbob.tests.audit.scenes_as_models import PENDULUM, audit_of, ball, ready
from plumbob.tests.support.page_document import plotted_inside


@pytest.fixture(name="found", scope="module")
def _found():
    return audit_of(ball(0.12), duration=0.2)


@pytest.mark.long
def test_the_card_says_the_error_the_choice_and_the_certificate(found):
    """Its lines are MJCF that sets what the row of what to do says."""
    said, *change = card(found)
    lines = dict(rows(answered(found)))
    error, choice, known = said.split(" · ")
    assert error == f"{lines['your error'].partition(' (')[0]} wrong after 0.2 s"
    assert known == f"certified to ±{metres(found.uncertainty)}"
    options = ElementTree.fromstring("\n".join(change)).attrib
    assert options
    for name, value in options.items():
        assert f"{name} {value}" in choice
        assert f'{name}="{value}" in place of ' in lines["to do"]
    shown = unescape(re.sub("<[^>]+>", "", page(answered(found), found, "")))
    assert said in shown.replace("\u00a0", " ")


@pytest.mark.long
def test_figures_are_drawn_from_the_audit(found):
    answer = answered(found)
    text = page(answer, found, "")
    assert len(plotted_inside(text)) == text.count('src="data:image/svg+xml,') == 3
    timeline = answer.figures[-1]
    assert [t["name"] for t in timeline.traces] == ["floor – geom 1"]
    lasting = found.touching.intervals("floor – geom 1")
    assert lasting[0, 0] == pytest.approx(0.064, abs=1.5e-3)  # it falls 2 cm first
    assert lasting[-1, 1] == pytest.approx(0.2)
    assert timeline.traces[0]["x"][:2] == pytest.approx(lasting[0])
    ends = found.touching.events
    assert ends == 2 * len(lasting) - (lasting[-1, 1] >= 0.2)
    assert f"{ends / 0.2:.3g} begin or cease to in a second" in timeline.caption


def test_contacts_are_looked_for_at_each_own_step():
    looks = np.asarray(0.1 * np.arange(5), dtype=float)
    touching = Touching(looks, {"a – b": np.array([False, True, True, False, True])})
    assert touching.intervals("a – b") == pytest.approx(np.array([[0.1, 0.3], [0.4, 0.5]]))
    assert touching.events == 3
    model = ready(ball(0.12))
    found = model.touching(script(model, duration=0.04))
    assert found.times == pytest.approx(0.001 * np.arange(40))
    assert found.pairs == {}


@pytest.mark.long
def test_a_picture_is_on_the_page_where_there_is_one(found):
    answer = answered(found)
    assert "No picture of the model" in page(answer, found, "")
    text = page(answer, found, "", b"drawn")
    assert "No picture of the model" not in text
    assert f'src="data:image/png;base64,{base64.b64encode(b"drawn").decode()}"' in text


def test_pictures_are_pngs_of_their_pixels():
    pixels = np.random.default_rng(0).integers(0, 256, (5, 7, 3), np.uint8)
    content = picture_module.png(pixels)
    assert content.startswith(b"\x89PNG\r\n\x1a\n")
    begin = content.index(b"IDAT")
    size = int.from_bytes(content[begin - 4 : begin])
    rows = np.frombuffer(zlib.decompress(content[begin + 4 : begin + 4 + size]), np.uint8)
    assert np.array_equal(rows.reshape(5, 22)[:, 1:].reshape(5, 7, 3), pixels)
    assert int.from_bytes(content[begin + 4 + size :][:4]) == zlib.crc32(
        content[begin:][: 4 + size]
    )


def test_a_machine_that_cannot_draw_gives_no_picture(monkeypatch):
    model = ball(0.12)
    monkeypatch.setattr("sys.executable", "/bin/false")
    assert picture_module.picture(model, model.qpos0) is None


@pytest.mark.long
def test_command_writes_the_page_and_names_the_model_as_it_was_given(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("arm").mkdir()
    Path("arm/rod.xml").write_text(PENDULUM.format(integrator="Euler"), "utf-8")
    short = ["audit", "arm/rod.xml", "--duration", "0.1", "--budget", "1"]
    assert main([*short, "--out", "pages"]) == 0
    printed = capsys.readouterr()
    assert printed.err.strip() == "pages/audit-rod.html"
    assert printed.out.startswith("rod.xml ")
    page = Path("pages/audit-rod.html").read_text("utf-8")
    assert "plumbob audit arm/rod.xml --duration=0.1" in page
    assert main([*short, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["model"] == "arm/rod.xml"
    assert main([*short, "--out", "arm/rod.xml"]) == 2
    assert capsys.readouterr().err.startswith("plumbob: out = 'arm/rod.xml'")
