"""Exit codes of what goes wrong on plumbob's own side: 4 for a defect, 130 when interrupted."""

import os
import re
import shlex
import signal
import tempfile
from pathlib import Path

import pytest

from plumbob.reports.cli import main
from plumbob.reports.commands import cite


@pytest.fixture(autouse=True)
def _temporary_folder(tmp_path, monkeypatch):
    """Tracebacks go where the test ends."""
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))


def _broken(*_, **__):
    raise ValueError("two\nlines of it")


@pytest.mark.parametrize("folder", ["there", "/nowhere/at/all"])
def test_a_defect_is_one_line_and_its_traceback_a_file(folder, capsys, monkeypatch):
    monkeypatch.setattr(cite, "systems", _broken)
    if folder != "there":
        monkeypatch.setattr(tempfile, "tempdir", folder)
    assert main(["cite"]) == 4
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert err.startswith("plumbob: a defect of plumbob itself: ValueError")
    if folder == "there":
        file = err.strip().rpartition("in ")[2].removesuffix(")")
        assert "in _broken" in Path(file).read_text("utf-8")
    else:
        assert f"{__file__}:" in err


@pytest.mark.parametrize("error", [KeyboardInterrupt, ImportError])
def test_an_interrupt_is_one_line(error, capsys, monkeypatch):
    """Where a library makes an error of its own of it, too."""

    def interrupted():
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            raise error from None

    usual = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(cite, "systems", interrupted)
    assert main(["cite"]) == 130
    assert capsys.readouterr().err == "plumbob: interrupted\n"
    assert signal.getsignal(signal.SIGINT) == usual


@pytest.mark.long
def test_a_study_is_kept_when_its_page_fails(tmp_path, capsys, monkeypatch):
    words = "validate --scenes linear-pendulum/overdamped --methods ode/rk4 --jobs 1 --out"
    with monkeypatch.context() as patched:
        patched.setattr("plumbob.reports.view.site.writing.write_study_pages", _broken)
        assert main([*words.split(), str(tmp_path)]) == 4
    (again,) = re.findall(
        r"the study is stored: `plumbob (.*)` draws its page$", capsys.readouterr().err.strip()
    )
    assert not (tmp_path / "index.html").exists()
    assert main(shlex.split(again)) == 0
    assert (tmp_path / "index.html").exists()
