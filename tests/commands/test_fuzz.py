"""Random command lines: one line and the right code, never a defect.

A few examples here; HYPOTHESIS_PROFILE=search runs thousands.
"""

import argparse
import os
import random
import signal
import tomllib
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from plumbob.reports.cli import COMMANDS, main, parser
from plumbob.tests.support.first_verdicts import without_first_verdict

SEARCH = os.environ.get("HYPOTHESIS_PROFILE", "") == "search"
EXAMPLES = 2500 if SEARCH else 8
# The scene of the stored study: of the second the page shows 3 runs beside the study's, not 71.
STORED = "simple-pendulum/free-large" if SEARCH else "linear-pendulum/overdamped"
LONGEST = 60  # [s] for one command
WORDS = tomllib.loads(Path(__file__).with_name("fuzz.toml").read_text("utf-8"))
ODD = {"BYTE": "\ud800", "LONG": "x" * 3000}  # what stands for them in that file
VALUES = {name: values for names, values in WORDS["values"].items() for name in names.split()}
ANY = [*WORDS["texts"], *WORDS["numbers"], *VALUES["changes"], *VALUES["file"]]
SLOW = [
    "validate",
    "audit",
    "recommend",
    "stability",
    "worst",
    "identify",
    "sweep",
]  # kept to one small scene and method


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with files of all kinds, and a small stored study."""
    made = tmp_path_factory.mktemp("files")
    filled(made)
    return made


def filled(made):
    """Fill a folder with files of all kinds, and a small stored study."""
    (made / "there.xml").write_text(
        "<mujoco><worldbody><body><joint type='hinge' axis='0 1 0'/>"
        "<geom size='0.1' pos='0 0 -1'/></body></worldbody></mujoco>"
    )
    (made / "bad.xml").write_text("<mujoco><worldbody>")
    (made / "empty.xml").write_text("")
    (made / "bytes.xml").write_bytes(bytes(range(256)) * 9)
    (made / "folder").mkdir()
    os.mkfifo(made / "fifo")
    (made / "dangling").symlink_to(made / "nowhere")
    (made / "store.sqlite3").write_bytes(b"SQLite format 3\0" + b"\0" * 200)
    wanted = ["--scenes", STORED, "--methods", "ode/dop853,mujoco/rk4", "--jobs", "1"]
    assert main(["validate", *wanted, "--out", str(made / "out")]) == 0


@cache
def _actions():
    """The arguments of every command."""
    top = parser(COMMANDS)
    commands = next(a for a in top._actions if isinstance(a, argparse._SubParsersAction))
    return {
        name: [a for a in one._actions if not isinstance(a, argparse._HelpAction)]
        for name, one in commands.choices.items()
    }


def _value(action, chosen, command):
    """A value for an argument: most often of the right kind."""
    if action.choices and chosen.random() < 0.8:
        return str(chosen.choice(list(action.choices)))
    name = action.dest
    values = VALUES.get(name, WORDS["numbers"])
    if chosen.random() < 0.08:
        values = ANY
    elif name == "within" and command not in ("worst", "identify"):
        values = WORDS["numbers"]
    elif name in ("scene", "scenes", "method", "methods") and command in SLOW:
        values = values[:2]
    value = chosen.choice(values)
    return ODD.get(value, value)


def random_words(command, chosen):
    """A random command line of a command."""
    words = [command]
    for action in _actions()[command]:
        likely = 0.95 if not action.option_strings else 1.0 if action.required else 0.25
        if (
            action.dest in ("scenes", "method", "methods", "budget", "duration", "jobs")
            and command in SLOW
        ):
            likely = 1.0
        if chosen.random() > likely or action.dest == "profile":
            continue
        count = action.nargs
        if not isinstance(count, int):
            count = 2 if count == "*" else 1
        values = [_value(action, chosen, command) for _ in range(count)]
        words += [*(action.option_strings[-1:]), *values]
    return words


@contextmanager
def _limited():
    """Raises TimeoutError in a command that takes too long."""

    def late(number, frame):
        raise TimeoutError(f"not done after {LONGEST} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(LONGEST)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def _code(words):
    """The exit code of a command, SystemExit included."""
    with _limited():
        try:
            return main(words)
        except SystemExit as ended:
            return int(ended.code or 0)


@settings(max_examples=EXAMPLES, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(command=st.sampled_from(COMMANDS), seed=st.integers(0, 2**32))
def test_no_command_line_is_a_defect(command, seed, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    words = random_words(command, random.Random(seed))
    code = _code(words)
    said = capsys.readouterr()
    assert code in (0, 1, 2, 3), f"{words}: {said.err}"
    if code == 2:
        assert len(without_first_verdict(said.err).strip().splitlines()) == 1, (
            f"{words}: {said.err}"
        )
