"""Hostile input of all kinds: the exit code, one line, no file left, in bounded time.

A bug that is planted inside still ends as a defect.
"""

import io
import os
import re
import shlex
import shutil
import signal
import struct
import sys
import tempfile
import time
import tomllib
import zipfile
from contextlib import chdir, redirect_stdout
from importlib import import_module
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.own_model.model import MujocoModel
from plumbob.models.border import Refused, border, one_line
from plumbob.reports.cli import main
from plumbob.reports.commands.audit import PATIENCE
from plumbob.tests.support.first_verdicts import without_first_verdict

CASES = tomllib.loads(Path(__file__).with_name("ends.toml").read_text("utf-8"))
LONGEST = 60.0  # [s] of processor time, without a budget that says more
BODY = "<body pos='0 0 1'><joint name='j' axis='0 1 0'/><geom size='.1' pos='.3 0 0'/></body>"
MOTOR = "<actuator><motor joint='j'/></actuator>"
BOX = (
    "<geom type='plane' size='1 1 .1'/>"
    "<body pos='0 0 .05'><freejoint/><geom type='box' size='.05 .05 .05'/></body>"
)
GRID = (
    "<flexcomp name='{}' type='grid' count='{}' spacing='.05 .05 .05' pos='0 0 1' dim='3'"
    " radius='.005' mass='1'><edge equality='true'/></flexcomp>"
)
FLAGS = "<flag fwdinv='enable' invdiscrete='enable'/>"
MODELS = MappingProxyType(
    {
        "motor.xml": ("", BODY, MOTOR),
        "inverse.xml": (f"<option>{FLAGS}</option>", BOX, ""),
        "inverse_rk4.xml": (f"<option integrator='RK4'>{FLAGS}</option>", BOX, ""),
        "pid.xml": (
            "",
            BODY,
            "<actuator><pid joint='j' kp='20' ki='10' kv='1'/></actuator>"
            "<keyframe><key name='start' ctrl='0.4'/></keyframe>",
        ),
        "memory.xml": ("<size memory='1K'/>", BOX, ""),
        "userdata.xml": ("<size nuserdata='2000000000'/>", BODY, ""),
        "stiff.xml": ("", BODY.replace("axis", "stiffness='1e300' axis"), ""),
        "deep.xml": ("", "<body>" * 3000 + "</body>" * 3000, ""),
        "pipe_of_mesh.xml": ("<asset><mesh name='m' file='pipe.stl'/></asset>", BODY, ""),
        "pipe_of_include.xml": ("<include file='pipe.stl'/>", BODY, ""),
        "texture.xml": (
            "<asset><texture name='t' type='2d' builtin='flat' width='60000' height='60000'/>"
            "</asset>",
            BODY,
            "",
        ),
        "replicated.xml": ("", f"<replicate count='200000'>{BODY}</replicate>", ""),
        "flexible.xml": ("", GRID.format("a", "60 60 60"), ""),
        "nan_of_many.xml": (
            "",
            f"<replicate count='2'>{BODY.replace('0 0 1', '0 0 nan', 1)}</replicate>",
            "",
        ),
        "grid.xml": ("", GRID.format("a", "12 12 12"), ""),
        "twice.xml": ("", GRID.format("a", "4 4 4") + GRID.format("b", "4 4 4"), ""),
    }
)
POLICIES = """
class Silent(Exception):
    def __str__(self):
        raise self


class Bare(BaseException):
    pass


class Array:
    def __array__(self, *_, **__):
        raise Bare


class Nameless:
    @property
    def __name__(self):
        raise Bare

    def __call__(self, *_):
        return [0.0]


NAMELESS = Nameless()


def silent(*_):
    raise Silent


def bare(*_):
    raise Bare


def ends(*_):
    raise SystemExit(0)


def returns(*_):
    return Array()


def generator(*_):
    raise GeneratorExit


def large(*_):
    return [1.0] * 100_000
"""


def _archive(file, change=lambda content: content, header=b""):
    """An archive of controls, its bytes changed, or with a header of its own."""
    content = io.BytesIO()
    if header:
        header += b" " * (64 - (len(header) + 11) % 64) + b"\n"
        with zipfile.ZipFile(content, "w") as archive:
            text = b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header
            archive.writestr("ctrl.npy", text)
    else:
        np.savez(content, ctrl=np.zeros((5, 1)))
    Path(file).write_bytes(change(bytearray(content.getvalue())))


def _set(content, places, value):
    """The content with a byte behind each of the two headers of a member of an archive set."""
    for mark, place in zip((b"PK\x03\x04", b"PK\x01\x02"), places, strict=True):
        content[content.find(mark) + place] = value
    return content


def _flipped(content):
    content[content.find(b"NUMPY") + 130] ^= 4
    return content


SHAPE = b"{'descr': '<f8', 'fortran_order': False, 'shape': (%d,), }"


def _archives():
    _archive("encrypted.npz", lambda content: _set(content, (6, 8), 1))
    _archive("compressed.npz", lambda content: _set(content, (8, 10), 97))
    _archive("flipped.npz", _flipped)
    _archive("huge.npz", header=SHAPE % 10**12)
    _archive("larger.npz", header=SHAPE % 10**23)
    _archive("broken.npz", header=b"{'descr': '<f8', 'shape': ((((")
    np.savez_compressed("zeros.npz", ctrl=np.zeros((20_000_000, 1)))


@pytest.fixture(name="made", scope="module")
def _made(tmp_path_factory):
    """A folder with hostile files of all kinds."""
    made = tmp_path_factory.mktemp("hostile")
    with chdir(made):
        _models()
        _archives()
        Path("text.csv").write_text("a\0b", "utf-8")
        Path("policies.py").write_text(POLICIES, "utf-8")
        Path("import_ends.py").write_text("raise SystemExit(0)", "utf-8")
        Path("import_bare.py").write_text("raise BaseException", "utf-8")
        _older_audits()
    return made


def _models():
    for name, (first, bodies, last) in MODELS.items():
        text = f"<mujoco>{first}<worldbody>{bodies}</worldbody>{last}</mujoco>"
        Path(name).write_text(text, "utf-8")
    for folder in ("links", "pipes"):
        Path(folder).mkdir()
        shutil.copy("motor.xml", f"{folder}/motor.xml")
    Path("links/outside.xml").symlink_to(Path("motor.xml").absolute())
    Path("links/loop.xml").symlink_to("loop.xml")
    Path("links/nowhere.xml").symlink_to("nowhere")
    shutil.copy("motor.xml", os.path.join(b"links", b"\xff.xml"))
    for pipe in ("pipe.stl", "pipes/pipe.xml"):
        os.mkfifo(pipe)
    for large in ("pipes/large.xml", "large.mjb"):
        with open(large, "wb") as file:
            file.truncate(3 * 2**30)  # without a block on the disk


def _older_audits():
    """Audits of motor.xml as an older one might have been stored."""
    printed = io.StringIO()
    with redirect_stdout(printed):
        assert (
            main([*["audit", "motor.xml", "--budget", "1", "--duration", "0.1", "--json"]]) == 0
        )
    text = printed.getvalue()
    error = re.compile(r'("error": )[-+.e\d]+')
    for name, digits in (("integers", 400), ("long_integers", 6000)):
        Path(f"{name}.json").write_text(error.sub(rf"\g<1>1{'0' * digits}", text), "utf-8")
    nul = text.replace('"motor.xml"', '"\\u0000"')
    Path("nul.json").write_text(nul, "utf-8")
    Path("deep.json").write_text("[" * 100_000, "utf-8")


MARKS = MappingProxyType({"short": (), "long": pytest.mark.long, "rare": pytest.mark.rare})
CALLS = [
    pytest.param(words, code, marks=MARKS[length])
    for length, lines in CASES.items()
    for words, code in lines.items()
]


@pytest.mark.parametrize(("words", "code"), CALLS)
def test_hostile_input_ends_with_a_code_and_leaves_nothing(
    words, code, made, monkeypatch, capfd
):
    monkeypatch.chdir(made)
    monkeypatch.delitem(sys.modules, "policies", raising=False)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    before = sorted(map(str, made.rglob("*")))
    begun = time.process_time()
    assert main(shlex.split(words)) == code
    budgets = re.findall(r"^audit .*--budget (\d+)", words)
    limits = [LONGEST, *(PATIENCE * float(budget) for budget in budgets)]
    assert time.process_time() - begun < min(limits)
    assert sorted(map(str, made.rglob("*"))) == before
    said = without_first_verdict(capfd.readouterr().err)
    assert said.count("\n") <= 1, said
    rows = words.startswith(("audit links", "audit pipes"))  # several audits: a table has them
    assert code != 2 or said.startswith("plumbob: ") or rows


AUDIT = "audit motor.xml --budget 1 --duration 0.1"
RUN = "simple-pendulum/free-large mujoco/euler --step 1e-2"
STUDY = "--scenes linear-pendulum/overdamped --methods mujoco/rk4 --jobs 1"
HINGE = "plumbob.engines.adapters.mujoco.simple_pendulum"
PLANTED = MappingProxyType(
    {
        "adapter": (MujocoModel, "stepped", AUDIT),
        "adapter, reading": (
            "plumbob.engines.adapters.mujoco.own_model.model",
            "field_texts",
            AUDIT,
        ),
        "another adapter": (
            "plumbob.engines.adapters.pinocchio.user_model",
            "Translated",
            f"{AUDIT} --engines pinocchio",
        ),
        "reference": ("plumbob.engines.audit.kept_reference", "certified", AUDIT),
        "template": ("plumbob.reports.view.audit.page", "worded", AUDIT),
        "run": (HINGE, "build", f"run {RUN}"),
        "run, theory": (HINGE, "model_error", f"run {RUN}"),
        "validate": (HINGE, "build", f"validate {STUDY} --out planted"),
        "validate, pages": (
            "plumbob.reports.view.site.claims",
            "findings_of",
            f"validate {STUDY} --out planted",
        ),
    }
)


class Here:
    """Workers that work in this process, in which the bug is."""

    def __init__(self, count):
        self.count = count

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def results(self, tasks, *_):
        return ((task, task.do(*task.arguments)) for task in tasks)


@pytest.mark.parametrize("place", PLANTED)
@pytest.mark.parametrize(
    "error", [ValueError, TypeError, KeyError, RuntimeError, BaseException]
)
def test_a_bug_that_is_planted_inside_stays_a_defect(
    place, error, made, monkeypatch, capfd, tmp_path
):
    def planted(*_, **__):
        raise error("planted")

    where, name, words = PLANTED[place]
    if "--engines" in words:
        pytest.importorskip("pinocchio")
    monkeypatch.chdir(made)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr("plumbob.engines.audit.engines.Workers", Here)
    monkeypatch.setattr(
        import_module(where) if isinstance(where, str) else where, name, planted
    )
    words = words.replace("--out planted", f"--out {tmp_path / 'out'}")
    assert main(shlex.split(words)) == 4
    assert "a defect of plumbob itself" in capfd.readouterr().err
    (traceback,) = tmp_path.glob("plumbob-defect-*")
    assert "in planted" in traceback.read_text("utf-8")


def test_interrupts_pass_the_border():
    for interrupt in (KeyboardInterrupt, MemoryError):
        with pytest.raises(interrupt), border():
            raise interrupt


def test_what_the_handler_of_a_signal_raises_passes_the_border():
    """A caller's own handler may end the process by SystemExit; a policy's is a refusal."""

    def ended(*_):
        raise SystemExit(7)

    before = signal.signal(signal.SIGTERM, ended)
    try:
        with pytest.raises(SystemExit), border():
            signal.raise_signal(signal.SIGTERM)
        with pytest.raises(Refused, match="SystemExit: 8"), border():
            raise SystemExit(8)
    finally:
        signal.signal(signal.SIGTERM, before)


def test_an_error_without_words_says_where_it_was_raised():
    class Silent(Exception):
        def __str__(self):
            raise self

    assert one_line(Silent()) == "Silent: no message"
    with pytest.raises(Refused, match="Silent: raised in test_an_error_without"), border():
        raise Silent
