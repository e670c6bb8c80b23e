"""Progress on stderr: fits the terminal, moves while a task runs, and is lines in a file."""

import io
import re
import sys

import pytest

from plumbob.reports.commands.arguments.console import progress

LONG = "capsule-line/heading-030 mujoco/euler+coulomb, derivative by friction"
ESCAPE = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


class Terminal(io.StringIO):
    """A terminal that keeps what it is sent."""

    def isatty(self):
        return True


@pytest.mark.parametrize("width", [20, 59, 60, 200])
def test_a_line_of_progress_fits_the_terminal(width, monkeypatch):
    """Its description is cut, the number of tasks and the time stay; a bar needs 60 columns."""
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setenv("TERM", "xterm")
    with progress(budget=60.0) as show:
        show(LONG, 3, 12)
    lines = [ESCAPE.sub("", line) for line in re.split(r"[\r\n]+", sys.stderr.getvalue())]
    (text,) = {line.rstrip() for line in lines if "3 of 12: " in line}
    assert len(text) <= width
    assert text.startswith("3 of 12: ")
    assert text.endswith(" of 60 s")
    assert ("━" in text or "╸" in text) == (width >= 60)
    assert (LONG in text) == (width == 200)


@pytest.mark.parametrize("lines", [False, True])
def test_a_file_gets_a_line_for_each_finished_task_or_nothing(lines, capsys):
    with progress(lines=lines) as show:
        show("a stage", 0, 0)
        show("first.xml audited", 1, 2)
    assert capsys.readouterr().err == "plumbob: 1 of 2: first.xml audited\n" * lines
