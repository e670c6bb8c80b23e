"""What no audit can follow is refused by name; bad input of the command is one line and exit 2."""

import json
import os
import tomllib
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.refusals import check_continuous
from plumbob.engines.own_motion import NotCertifiable
from plumbob.reports.cli import main
from plumbob.tests.audit.scenes_as_models import PENDULUM, pendulum
from plumbob.tests.support.first_verdicts import without_first_verdict

CASES = tomllib.loads(Path(__file__).with_name("refused.toml").read_text("utf-8"))
HOSTILE = CASES["hostile"]


BY_REASON = [(reason, text, ["--budget", "5"]) for reason, text in CASES["refused"].items()]
BY_REASON += [
    (reason, text, ["--contacts"]) for reason, text in CASES["refused_contacts"].items()
]
BOX = CASES["refused_contacts"]["no gravity"].replace(' gravity="0 0 0"', "")
OPTIONS = [(words.split(" "), reason) for words, reason in CASES["bad_options"].items()]


def one_line(words, reason, capsys):
    """The command ends with exit code 2, and with a line that has the reason in it."""
    assert main(["audit", *words]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("plumbob: ")
    assert printed.err.count("\n") == 1, printed.err
    assert reason in printed.err


@pytest.mark.parametrize(("reason", "text", "words"), BY_REASON)
def test_refused_by_name(reason, text, words, tmp_path, capsys):
    path = tmp_path / "my.xml"
    path.write_text(text, "utf-8")
    mujoco.MjModel.from_xml_path(str(path))
    one_line([str(path), *words], reason, capsys)


@pytest.mark.parametrize(
    ("words", "reason"),
    [*OPTIONS, (["--speed", "1"], "speed = 1.0: must be given with --contacts")],
)
def test_bad_options_of_contacts_are_one_line(words, reason, files, capsys):
    Path("my.xml").write_text(BOX, "utf-8")
    before = sorted(files.iterdir())
    contacts = ["--contacts"] if (words, reason) in OPTIONS else []
    one_line(["my.xml", *contacts, *words], reason, capsys)
    assert sorted(files.iterdir()) == before


class WithPluginState:
    """A model that says it has a plugin with numbers of its own; no plugin of MuJoCo's own has."""

    nplugin = 1
    plugin_statenum = (2,)

    def __init__(self, model):
        self.model = model

    def __getattr__(self, name):
        return getattr(self.model, name)


def test_a_plugin_with_a_state_of_its_own_is_refused():
    with pytest.raises(NotCertifiable, match="a plugin with a state of its own"):
        check_continuous(WithPluginState(pendulum()))


@pytest.fixture(name="files")
def _files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = PENDULUM.format(integrator="Euler")
    models = {
        "my.xml": text,
        "secret.xml": text,
        "no_step.xml": text.replace('"0.01"', '"nan"'),
    }
    written = CASES["files"] | models
    for name, content in written.items():
        Path(name).write_text(content, "utf-8")
    Path("secret.xml").chmod(0)
    latin = text.replace("rod", "r\xf6d")
    Path("latin.xml").write_text(f'<?xml version="1.0" encoding="latin-1"?>{latin}', "latin-1")
    for name in ("pipe", "pipe.csv"):
        os.mkfifo(name)
    for name in ("folder", "folder.csv"):
        Path(name).mkdir()
    np.savez("other.npz", other=np.zeros(3))
    np.savez("objects.npz", ctrl=np.array([{}], dtype=object))
    np.savez("cube.npz", ctrl=np.zeros((2, 1, 1)))
    np.savez("complex.npz", ctrl=np.array([1j]))
    return tmp_path


# Root may read everything.
TRIED = [case for case in HOSTILE if os.geteuid() or case != "a file without permission"]


@pytest.mark.parametrize("case", TRIED)
def test_hostile_input_is_one_line(case, files, capsys):
    before = sorted(files.rglob("*"))
    one_line(HOSTILE[case], "", capsys)
    assert sorted(files.rglob("*")) == before


@pytest.mark.long
def test_exit_codes_and_json(files, capsys):
    short = ["audit", "my.xml", "--duration", "0.2", "--budget", "20"]
    assert main([*short, "--absolute", "0.1", "--verbose"]) == 0
    text = capsys.readouterr()
    assert without_first_verdict(text.err) == ""
    for row in ("reference", "your error", "halving", "cheapest", "predictable", "not claimed"):
        assert f"\n{row} " in text.out
    assert main([*short, "--absolute", "1e-9", "--json"]) == 1
    printed = capsys.readouterr()
    assert "m off" in printed.err
    data = json.loads(printed.out)
    assert data["worst_body"] == "rod"
    assert data["error"] > 5 * data["uncertainty"] > 0.0


def test_no_reference_is_an_answer(capsys, files):
    """Exit code 0, also where the answer is "no reference, because ..."."""
    code = main(["audit", "my.xml", "--budget", "1e-9", "--verbose"])
    printed = capsys.readouterr()
    assert code == 0
    assert "none: the time given for it ended" in printed.out
