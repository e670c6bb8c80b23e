"""Bad input that once ended in a traceback or a hang: one line, exit code 2, nothing written."""

from __future__ import annotations

import json
import os
import sqlite3
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbob.engines.method import Engine
from plumbob.engines.study import store
from plumbob.engines.study.codec import from_json, to_json
from plumbob.engines.trajectory import Trajectory
from plumbob.reports.cli import main
from plumbob.reports.judge import benchmarks

CONE = "cone-pendulum/rotating-base"
SMALL = "linear-pendulum/overdamped"  # of which the page shows few runs
VALIDATE = ("validate", "--scenes", CONE, "--methods", "ode/rk4", "--jobs", "1")
MOST = 700  # characters of a line, with a value of 200: a few lines of a terminal
SETTINGS = ("settings", "mujoco/euler+coulomb")
DEEP, DEEP_OBJECT = "[" * 100_000, '{"a":' * 100_000
BALL = """<mujoco><option timestep="{}"/><worldbody><geom type="plane" size="1 1 1"/>
<body pos="0 0 0.1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>"""
DECLARED = '<?xml version="1.0" encoding="{}"?><mujoco/>'
BAD = {
    "jobs as a superscript": (*VALIDATE[:-1], "²"),
    "a time before the start": ("solve", CONE, "--times=0.1,-0.1"),
    "no jobs": (*VALIDATE[:-1], "0"),
    "a folder as the JUnit file": (*VALIDATE, "--junitxml", "."),
    "a pipe as the JUnit file": (*VALIDATE, "--junitxml", "pipe"),
    "a device as the JUnit file": (*VALIDATE, "--junitxml", "/dev/null"),
    "a dangling link as the JUnit file": (*VALIDATE, "--junitxml", "dangling"),
    "a pipe in the page's place": (*VALIDATE, "--out", "with-pipes"),
    "a pipe in the store's place": ("report", "with-pipes"),
    "a study number as a superscript": ("compare", "out#²", "out"),
    "a study number beyond 64 bits": ("compare", "out#99999999999999999999", "out"),
    "a study number below them": ("compare", "out#9999999999999999999", "out"),
    "study 0": ("compare", "out#0", "out"),
    "no study number": ("compare", "out#", "out"),
    "study 0 of a report": ("report", "out", "--study", "0"),
    "a report's study beyond 64 bits": ("report", "out", "--study", "9" * 20),
    "a pipe as a model": ("run", CONE, "--like", "pipe"),
    "a device as a model": ("run", CONE, "--like", "/dev/zero"),
    "a folder as a model": ("run", CONE, "--like", "out"),
    "a huge file as a model": ("run", CONE, "--like", "huge.xml"),
    "a model's name that is no UTF-8": ("run", CONE, "--like", os.fsdecode(b"\xff.xml")),
    "a pipe to check": ("settings", "--check", "pipe"),
    "a device to check": ("settings", "--check", "/dev/zero"),
    "a huge file to check": ("settings", "--check", "huge.xml"),
    "a folder to check": ("settings", "--check", "out"),
    "an encoding to check that no one knows": ("settings", "--check", "encoding.xml"),
    "a null byte in a model's name": ("run", CONE, "--like", "a\0.xml"),
    "a null byte in a folder's name": (*VALIDATE, "--out", "a\0b"),
    "a null byte in an option's value": (*VALIDATE, "--junitxml=a\0b"),
    "a null byte in a store's name": ("report", "a\0b"),
    "a null byte in a command": ("re\0port", "out"),
    "a list for a track": ("solve", "capsule-plan", "--set", "track=[[]]"),
    "a condim of 2": ("run", CONE, "--like", "condim.xml"),
    "an encoding that no one knows": ("run", CONE, "--like", "encoding.xml"),
    "an infinite step": ("run", CONE, "--like", "infinite.xml"),
    "a heading of 1e17 rad": ("plan", "--to", "0", "0", "1e17"),
    "a place 1e17 m away": ("plan", "--to", "1e17", "0", "0"),
    "an angular speed that overflows": ("solve", "simple-pendulum", "--set", "theta_dot=1e30"),
    "gravity that underflows": ("solve", "simple-pendulum", "--set", "gravity=1e-308"),
    "friction that never ends a turn": ("solve", "capsule-turn", "--set", "friction=1e-308"),
    "a length that overflows": (
        "run",
        "simple-pendulum",
        "ode/rk4",
        "--step",
        "1e-3",
        "--set",
        "length=1e308",
    ),
    "a list nested 100,000 deep": ("solve", "capsule-line", "--set", f"supports={DEEP}"),
    "an object nested deep": ("plan", "--to", "0", "0", "1", "--set", f"legs={DEEP_OBJECT}"),
    "a nested list for a length": (
        "run",
        "simple-pendulum",
        "ode/rk4",
        "--step",
        "1e-3",
        "--set",
        f"length={DEEP[:900]}{DEEP[:900].replace('[', ']')}",
    ),
    "benchmarks that are nested deep": ("compare", "deep.jsonl", "deep.jsonl"),
    "settings for a step that overflows": (*SETTINGS, "--step", "1e300"),
    "settings for a step that underflows": (*SETTINGS, "--step", "1e-300"),
    "settings for the smallest step": (*SETTINGS, "--step", "5e-324"),
    "settings for contacts of no stiffness": (*SETTINGS, "--step", "1e-3", "--stiffness", "1e-300"),
    "models for a step that overflows": ("models", "export", "models", "--step", "1e300"),
    "models for a step that underflows": ("models", "export", "models", "--step", "1e-300"),
    "a file with a step that underflows": ("settings", "--check", "short.xml"),
    "a model with a step that underflows": ("audit", "short.xml"),
    "contacts with a step that underflows": ("audit", "short.xml", "--contacts"),
    "contacts with a step that overflows": ("audit", "long.xml", "--contacts"),
    "export onto a pipe": ("models", "export", "pipes"),
    "export through a dangling link": ("models", "export", "links"),
    "export into a link for a folder": ("models", "export", "folders"),
}


@pytest.fixture
def inputs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with files of every kind but the right one."""
    monkeypatch.chdir(tmp_path)
    for folder in ("out", "with-pipes", "pipes/cone_pendulum", "links/cone_pendulum", "folders"):
        Path(folder).mkdir(parents=True)
    for pipe in (
        "pipe",
        "with-pipes/index.html",
        f"with-pipes/{store.FILE}",
        "pipes/cone_pendulum/cone_pendulum.xml",
    ):
        os.mkfifo(pipe)
    for link in ("dangling", "links/cone_pendulum/cone_pendulum.xml", "folders/cone_pendulum"):
        Path(link).symlink_to(tmp_path / "nowhere")
    with Path("huge.xml").open("wb") as huge:
        huge.truncate(200_000_000)
    Path("condim.xml").write_text('<mujoco><default><geom condim="2"/></default></mujoco>')
    Path("encoding.xml").write_text(DECLARED.format("klingon"))
    Path("short.xml").write_text(BALL.format("1e-300"))
    Path("long.xml").write_text(BALL.format("1e300"))
    Path("deep.jsonl").write_text(f'{benchmarks.START}, "made": {DEEP}')
    Path("infinite.xml").write_text('<mujoco><option timestep="inf"/></mujoco>')
    return tmp_path


@pytest.mark.parametrize("words", BAD.values(), ids=BAD)
def test_it_is_one_line_and_nothing_is_written(
    words: tuple[str, ...], inputs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(inputs.rglob("*"))
    code = main(words)
    out, err = capsys.readouterr()
    assert (code, out, err.count("\n")) == (2, "", 1), err
    assert err.startswith("plumbob: ")
    assert len(err) < MOST, err
    assert sorted(inputs.rglob("*")) == before


RUN = ("run", "capsule-coast", "mujoco/euler+coulomb", "--step", "1e-3", "--set")
TO = ("plan", "--to", "0.02", "0.01", "0.3", "--set")
BLAMED = {  # what was changed is named, with the value and what is computed of it
    ("solve", "simple-pendulum", "--set", "length=1e-300"): "such that inertia is greater than 0, ",
    ("run", "simple-pendulum", "ode/rk4", "--step", "1e-3", "--set", "length=1e-300"): "such that ",
    ("run", "linear-pendulum", "ode/rk4", "--step", "1", "--set", "length=1e-20"): "such that dur",
    ("recommend", "simple-pendulum", "--error", "0.1", "--set", "length=1e-300"): "such that ",
    ("solve", "capsule-line", "--set", "w1=1e20"): "such that normal_force_2 is greater than 0 ",
    ("solve", "capsule-line", "--set", "t1=5e-324"): "such that path velocity after piece 1 is ",
    ("solve", "capsule-hold", "--set", "length=5e-324"): "such that duration is greater than 0, ",
    ("solve", "capsule-coast", "--set", "gravity=5e-324"): "such that normal_force_1 is ",
    ("solve", "capsule-coast", "--set", "velocity_x=1e300"): "such that double precision holds ",
    ("solve", "capsule-coast", "--set", "velocity_y=-1e160"): "such that double precision holds ",
    (*RUN, "slider_mass=1e300"): "such that double precision holds ",
    (*TO, "inertia=1e300"): "such that double precision holds ",
    (*TO, "friction=1e-300"): "such that double precision holds ",
    (*TO, "acceleration=1e300"): "such that double precision holds ",
    (*TO, "radius=1e160"): "small enough to keep every support pressed ",
    (*TO, "stroke=5e-324"): "large enough for a turn",
}


@pytest.mark.parametrize("words", BLAMED, ids=lambda words: f"{words[1]} {words[-1]}")
def test_what_was_changed_is_named(
    words: tuple[str, ...], inputs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    out, err = capsys.readouterr()
    name, _, value = words[-1].partition("=")
    assert out == ""
    assert err.startswith(f"plumbob: {name} = {json.loads(value)!r}: must be {BLAMED[words]}")


def test_all_that_was_changed_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    changes = ("--set", "length=1e-300", "--set", "gravity=3")
    assert main(("solve", "simple-pendulum", *changes)) == 2
    named = "plumbob: set = {'length': 1e-300, 'gravity': 3}: must be such that inertia is greater"
    assert capsys.readouterr().err.startswith(named)


@pytest.mark.parametrize(
    ("scene", "change", "verdict"),
    [
        ("capsule-coast", "friction=1e300", "diverged"),
        ("capsule-coast", "velocity_x=1e20", "diverged"),
        ("capsule-coast", "gravity=1e20", "unsupported (at this step the body tips over"),
        ("capsule-line", "inertia=1e-20", "unsupported (MuJoCo refuses the model"),
    ],
)
def test_a_run_that_cannot_begin_is_a_verdict(
    scene: str, change: str, verdict: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(("run", scene, *RUN[2:], change)) == 1
    out, err = capsys.readouterr()
    assert f" at 0.001: {verdict}" in out
    assert err == ""


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    ("scene", "method", "verdict"),
    [
        ("capsule-hold/0.999", "ode/rk4", None),
        ("capsule-turn/0.3", "exact/closed-form", "unsupported"),
        (SMALL, "heyoka/*", "missing"),
    ],
)
def test_a_study_without_a_run_has_a_page(
    scene: str,
    method: str,
    verdict: str | None,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def there(engine: Engine) -> bool:
        return engine.name != "heyoka"

    for module in ("engines.registry", "engines.study.measurement", "engines.study.extra_runs"):
        monkeypatch.setattr(f"plumbob.{module}.installed", there, raising=False)
    words = ["validate", "--scenes", scene, "--methods", method, "--jobs", "1"]
    code = main([*words, "--out", str(tmp_path)])
    out, err = capsys.readouterr()
    assert (code, err) == (3 if verdict == "missing" else 0, "")
    assert verdict is None or verdict in out
    assert scene.replace("/", "/<wbr>") in (tmp_path / "index.html").read_text("utf-8")


def test_names_of_folders_may_hold_anything(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = str(tmp_path / os.fsdecode(b"a#1 \xff"))
    words = ["validate", "--scenes", SMALL, "--methods", "ode/rk4", "--out", out, "--jobs", "1"]
    monkeypatch.setattr("sys.argv", ["plumbob", *words])
    assert main(words) == 0
    assert main(["compare", out, f"{out}#1"]) == 0
    assert capsys.readouterr().out.endswith("nothing has moved\n")


def _damaged(file: Path, table: str, body: str) -> None:
    """Every body in a table put in another's place, as by a program whose checksums fit."""
    with closing(sqlite3.connect(file)) as held, held:
        held.execute(f"update {table} set body = {body}")
        columns = {"study": "id, plan, body, results", "result": "study, key, body"}[table]
        for number, *row in held.execute(f"select rowid, {columns} from {table}").fetchall():
            change = f"update {table} set digest = ? where rowid = ?"
            held.execute(change, (store._digest(*row), number))


DAMAGE = ("'[]'", "'null'", "'7'", "'\"text\"'", "'{\"a\": 1}'", "'{'", "char(0)", "7", "x'ff'")


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("table", ["study", "result"])
@pytest.mark.parametrize("command", ["report", "compare"])
def test_a_store_that_cannot_be_read_back_is_bad_input(
    command: str,
    table: str,
    damage: str,
    stored: bytes,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / store.FILE).write_bytes(stored)
    _damaged(tmp_path / store.FILE, table, damage)
    assert main([command, *([str(tmp_path)] * (2 if command == "compare" else 1))]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "must be a file of stored results" in err
    assert not (tmp_path / "index.html").exists()
    with closing(sqlite3.connect(tmp_path / store.FILE, timeout=0)) as held:
        held.execute("begin exclusive")  # no lock is left behind


@pytest.mark.long
def test_a_finding_whose_numbers_a_store_lacks_is_left_out_and_the_page_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As one of another version, whose templates asked for other numbers."""
    chosen = ["--scenes", "cone-pendulum/deep-well", "--methods", "ode/rk4", "--jobs", "1"]
    assert main(["validate", *chosen, "--out", str(tmp_path)]) == 0
    study = store.load(tmp_path / store.FILE)
    assert study is not None
    (old,) = [a for a in study.analyses if a.template == "cone_pendulum/equilibria"]
    lacking = replace(old, numbers={n: v for n, v in old.numbers.items() if n != "fork"})
    analyses = tuple(lacking if a is old else a for a in study.analyses)
    store.save(replace(study, analyses=analyses), tmp_path / store.FILE)
    capsys.readouterr()
    assert main(["report", str(tmp_path)]) == 0
    assert capsys.readouterr().err == ""
    (page,) = tmp_path.glob("site-*/cone-pendulum.html")
    text = page.read_text("utf-8")
    assert "Not shown by this study: 1 of the findings" in text
    assert "cone_pendulum/equilibria (&#39;fork&#39; is undefined)" in text
    assert "Two equilibria become four" not in text


def test_runs_of_a_study_that_is_not_there_are_bad_input(
    stored: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / store.FILE).write_bytes(stored)
    with closing(sqlite3.connect(tmp_path / store.FILE)) as held, held:
        held.execute("delete from study")
    words = ["recommend", SMALL, "--error", "1e-3", "--stored", "--out", str(tmp_path)]
    assert main(words) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert "(study 1 is not as it was stored)" in err


@pytest.mark.parametrize(
    "text", [b"body text, results", b'"scene": "linear-pendulum'], ids=["definition", "value"]
)
def test_a_store_with_a_text_that_is_no_utf_8_is_bad_input(
    text: bytes, stored: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert text in stored
    (tmp_path / store.FILE).write_bytes(stored.replace(text, text[:-3] + b"\xff" + text[-2:]))
    assert main(["report", str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith("plumbob: store = ")


@pytest.mark.parametrize("kept", [0.1, 0.5, 0.9])
def test_a_store_that_was_cut_off_is_bad_input(
    kept: float, stored: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / store.FILE).write_bytes(stored[: int(kept * len(stored))])
    assert main(["report", str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith("plumbob: store = ")


@pytest.mark.parametrize("table", ["study", "result"])
def test_an_unknown_field_in_a_store_is_left_out(
    table: str, stored: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / store.FILE).write_bytes(stored)
    _damaged(tmp_path / store.FILE, table, "'{\"later\": 1, ' || substr(body, 2)")
    assert main(["report", str(tmp_path)]) == 0
    assert capsys.readouterr().err == ""


def test_a_damaged_recording_is_no_recording() -> None:
    held = json.loads(to_json(Trajectory(np.zeros(1), {"theta": np.zeros(1)})))
    shape, numbers = held["times"]
    for times in ([shape, numbers[:-8]], [shape, ""], [[7], numbers], [shape], numbers, None):
        with pytest.raises(ValueError, match="no Trajectory"):
            from_json(json.dumps({**held, "times": times}), Trajectory)


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The store of a small study, whose page is drawn quickly."""
    folder = tmp_path_factory.mktemp("stored")
    words = ["validate", "--scenes", SMALL, "--methods", "ode/rk4", "--out", str(folder)]
    assert main([*words, "--jobs", "1"]) == 0
    return (folder / store.FILE).read_bytes()
