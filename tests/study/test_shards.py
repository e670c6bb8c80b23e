"""Shards of a plan are merged into what one command gives, and refused where they do not fit."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import plumbob
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import methods
from plumbob.engines.study import store
from plumbob.engines.study.checkpoint import measured_into
from plumbob.engines.study.codec import to_json
from plumbob.engines.study.extra_runs import ExtraRun
from plumbob.engines.study.merge import merged_study
from plumbob.engines.study.provenance import result_versions
from plumbob.engines.study.runner import run_study
from plumbob.engines.study.shard import Shard
from plumbob.engines.study.store_file import writing
from plumbob.engines.sweep.store import stored_sweeps
from plumbob.engines.workers import Workers
from plumbob.models.registry import matching_scenes
from plumbob.reports.cli import main
from plumbob.reports.commands.shared.audit_shards import (
    audit_shard_file,
    merged_audits,
    shard_of_files,
    write_audit_shard,
)
from plumbob.reports.commands.shared.several_audits import Row
from plumbob.reports.records.plain_data import json_text

SCENES = "incline/rest,projectile/thrown"
PLAN = matching_scenes(SCENES), methods("mujoco/euler,mujoco/rk4")
ROOT = Path(plumbob.__file__).parent
ROD = """<mujoco><option timestep="{step}"/><worldbody><body><joint axis="0 1 0"/>
<geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>"""
TIMES = {"compile_seconds", "ns_per_step", "real_time_factor", "seconds"}
SWEEP = ["capsule-line", "mujoco/euler", "--vary", "heading=0:6:7", "--jobs", "1"]


def one_more_run(plan):
    """A run of the second scene that no pair of the plan has."""
    return (ExtraRun("projectile/thrown", "mujoco/implicit", 0.05),)


def measured(folder, shard=None, plan=PLAN):
    """The study of a plan, or of one shard, stored in `folder`."""
    folder.mkdir(exist_ok=True)
    with measured_into(folder / store.FILE) as kept:
        return run_study(*plan, kept=kept, timed=False, requests=one_more_run, shard=shard)


def merged(out, *folders):
    out.mkdir()
    with Workers(1) as workers, measured_into(out / store.FILE) as kept:
        return merged_study(folders, kept, workers, lambda study, workers: ())


def timeless(value):
    """A JSON value without times of this machine: those name their unit."""
    if isinstance(value, dict):
        return {key: timeless(of) for key, of in value.items() if "seconds" not in key}
    return [timeless(of) for of in value] if isinstance(value, list) else value


def runs_of(study):
    """All runs of a study in their order, without processor times."""
    extras = [of for of in study.extras.items() if isinstance(of[0], ExtraRun)]
    parts = [study.convergence, extras, study.scenes, study.methods, study.seed]
    return timeless(json.loads(to_json(parts)))


@pytest.fixture(scope="module")
def shards(tmp_path_factory):
    """Two shards of the plan, each in its folder, and the folders' parent."""
    parent = tmp_path_factory.mktemp("shards")
    for number in (1, 2):
        measured(parent / str(number), Shard(number, 2))
    return parent


@pytest.mark.parametrize("count", [1, 2, 5, 30])
def test_shards_divide_a_plan(count):
    """Each part is in one shard, and no shard has more than the largest part over the mean."""
    work = {f"scene {k}": float(k % 7 + 1) for k in range(23)}
    parts = [Shard(number, count).parts(work) for number in range(1, count + 1)]
    assert sorted(name for part in parts for name in part) == sorted(work)
    loads = [sum(work[name] for name in part) for part in parts]
    assert max(loads) <= sum(work.values()) / count + max(work.values())


def test_a_merged_study_is_the_whole_one_to_the_bit(shards, tmp_path):
    whole = measured(tmp_path / "whole")
    study = merged(tmp_path / "merged", shards / "2", shards / "1")
    assert len(study.convergence) == 4
    assert runs_of(study) == runs_of(whole)
    assert runs_of(store.load(tmp_path / "merged" / store.FILE)) == runs_of(whole)
    assert store.load(shards / "1" / store.FILE) is None  # a shard is no study of its own


def changed(folder, **fields):
    """Changes fields of the stored record of its one shard."""
    with writing(folder / store.FILE) as opened:
        number, (record,) = store.newest_shards(opened)
        store.keep_shard(opened, number, replace(record, **fields))


REFUSED = {
    "missing": "must be all shards of a plan; missing: 2/2",
    "twice": "must be another shard than",
    "versions": "must be measured with mujoco 2.0.0 as",
    "sources": "must be measured by this plumbob: its files have changed since",
    "plan": "must be a shard of the same plan as",
    "damaged": "must be as it was stored: measure shard 2/2 again",
    "unfinished": "must be a folder with a whole shard of one command",
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_does_not_fit_is_refused_in_one_line(case, shards, tmp_path, capsys):
    folders = [tmp_path / "1", tmp_path / "2"]
    for folder in folders:
        shutil.copytree(shards / folder.name, folder)
    first, second = folders
    if case == "missing":
        folders.pop()
    elif case == "twice":
        folders.append(tmp_path / "2" / ".." / "1")
    elif case == "versions":
        changed(first, versions={**result_versions(), "mujoco": "2.0.0"})
    elif case == "sources":
        changed(second, sources="other")
    elif case == "plan":
        changed(second, plan="other")
    else:
        with writing(second / store.FILE) as opened:
            what = "key glob 'shard *'" if case == "unfinished" else "length(key) = 64"
            opened.execute(f"delete from result where {what}")
    assert main(["merge", *map(str, folders), "--out", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert REFUSED[case] in err


@pytest.mark.parametrize(
    ("words", "named"),
    [
        ("merge nowhere", "OUT = 'nowhere': must be a folder with a whole shard"),
        ("merge . --out .", "out = '.': must be another folder than those of the shards"),
        ("validate --shard 3/2", "shard = '3/2': must be K/N"),
        ("validate --shard 0/2", "shard = '0/2': must be K/N"),
        ("validate --shard 1/10000", "shard = '1/10000': must be K/N"),
        ("validate --shard 1/2 --json", "json = True: must be left out with --shard"),
        (
            "sweep capsule-line mujoco/euler --vary heading=0:6:7 --shard x",
            "shard = 'x': must be",
        ),
        ("audit models --shard 1/2", "out = None: must be given with --shard"),
        ("audit models/rod.xml --shard 1/2 --out o", "shard = '1/2': must be left out with"),
    ],
)
def test_what_cannot_be_used_is_one_line(words, named, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").mkdir()
    for name in ("rod", "bar"):
        (tmp_path / "models" / f"{name}.xml").write_text(ROD.format(step=1e-3))
    assert main(words.split()) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert named in err
    assert [path.name for path in tmp_path.iterdir()] == ["models"]


def printed(capsys, *words, code=0):
    """What a command prints, read as JSON if it is."""
    assert main(list(map(str, words))) == code
    out, _ = capsys.readouterr()
    return json.loads(out) if "--json" in words else out


def test_a_merged_sweep_is_the_whole_one_to_the_bit(tmp_path, capsys):
    """Three shards of seven points; the shard of another sweep is refused."""
    out = [tmp_path / str(number) for number in range(4)]
    whole = printed(capsys, "sweep", *SWEEP, "--out", out[0], "--json")
    for number in (1, 2, 3):
        said = printed(capsys, "sweep", *SWEEP, "--out", out[number], "--shard", f"{number}/3")
        assert said.startswith(f"shard {number}/3: ")
    study = printed(capsys, "merge", *out[1:], "--out", tmp_path / "all", "--json")
    page = study.pop("page")
    assert study == {name: value for name, value in whole.items() if name != "page"}
    assert page.startswith(str(tmp_path / "all"))
    (errors,) = (of.errors for of in stored_sweeps(tmp_path / "all" / "sweeps.sqlite3"))
    (expected,) = (of.errors for of in stored_sweeps(out[0] / "sweeps.sqlite3"))
    assert np.array_equal(errors, expected, equal_nan=True)
    other = [word.replace(":7", ":8") for word in SWEEP]
    printed(capsys, "sweep", *other, "--out", out[3], "--shard", "3/3")
    assert main(["merge", *map(str, out[1:]), "--out", str(tmp_path / "none")]) == 2
    assert "must be a shard of the same plan" in capsys.readouterr().err


@pytest.fixture
def models(tmp_path):
    """Three models of which one is broken."""
    files = []
    for name, step in (("fine/rod", 1e-3), ("coarse/rod", 1e-2), ("broken", "x")):
        file = (tmp_path / "models" / name).with_suffix(".xml")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(ROD.format(step=step))
        files.append(file)
    return files


def test_rows_of_audits_come_back_as_they_were_stored(models, tmp_path):
    """Rows, pages and records of three models in two shards; a model that changes is refused."""
    rows = [
        Row(
            str(file),
            error,
            1e-3,
            "a smaller step",
            k,
            {"error": error, "rows": [1, 2]},
            f"{k}.html",
        )
        for k, (file, error) in enumerate(zip(models, (1e-9, float("inf"), None), strict=True))
    ]
    folders = [tmp_path / "1", tmp_path / "2"]
    for number, folder in enumerate(folders, 1):
        shard = Shard(number, 2)
        folder.mkdir()
        own = [rows[models.index(file)] for file in shard_of_files(shard, models)]
        for row in own:
            (folder / row.page).write_text(row.path)
        write_audit_shard(
            audit_shard_file(shard, folder), shard, own, models, {"duration": 1.0}
        )
    (tmp_path / "all").mkdir()
    found = merged_audits(folders, tmp_path / "all")
    assert json_text(
        [vars(row) for row in sorted(found, key=lambda row: row.code)]
    ) == json_text([vars(row) for row in rows])
    pages = {path.name: path.read_text() for path in (tmp_path / "all").iterdir()}
    assert pages == {row.page: row.path for row in rows}
    models[0].write_text(ROD.format(step=2e-3))
    write_audit_shard(audit_shard_file(shard, folder), shard, own, models, {"duration": 1.0})
    with pytest.raises(ParameterError, match="must be a shard of the same plan as"):
        merged_audits(folders, tmp_path / "all")


@pytest.mark.rare
def test_merged_audits_are_those_of_one_command(models, tmp_path, capsys):
    words = ["audit", tmp_path / "models", "--duration", "0.1", "--budget", "5"]
    out = [tmp_path / str(number) for number in range(3)]
    whole = printed(capsys, *words, "--out", out[0], "--json", code=2)
    codes = [
        main([*map(str, words), "--out", str(out[k]), "--shard", f"{k}/2"]) for k in (1, 2)
    ]
    assert sorted(codes) == [0, 2]
    capsys.readouterr()
    rows = printed(capsys, "merge", *out[1:], "--out", tmp_path / "all", "--json", code=2)
    assert [row["path"] for row in rows] == [row["path"] for row in whole]
    for row, expected in zip(rows, whole, strict=True):
        for name in ("error", "certified_until", "uncertainty", "why"):
            assert row.get(name) == expected.get(name)
        errors = [[step["error"] for step in of.get("steps", ())] for of in (row, expected)]
        assert errors[0] == errors[1]
    names = [{path.name for path in of.iterdir()} for of in (tmp_path / "all", out[0])]
    assert names[0] == names[1]


KILLED = """
import os, signal, sys
from plumbob.engines.study.checkpoint import Checkpoint
from plumbob.reports.cli import main
keep = Checkpoint.keep
def ended(self, results):
    keep(self, results)
    os.kill(os.getpid(), signal.SIGKILL)
Checkpoint.keep = ended
main(sys.argv[1:])
"""


@pytest.mark.rare
def test_a_killed_shard_goes_on_and_the_merged_study_is_the_whole_one(tmp_path, capsys):
    """By the command line, with analyses, costs and pages: all records but their times."""
    words = [
        "validate",
        "--scenes",
        SCENES,
        "--methods",
        "mujoco/euler,mujoco/rk4",
        "--jobs",
        "1",
    ]
    whole = printed(capsys, *words, "--out", tmp_path / "0", "--json")
    folders = [str(tmp_path / str(number)) for number in (1, 2)]
    second = [*words, "--out", folders[1], "--shard", "2/2"]
    ended = subprocess.run([sys.executable, "-c", KILLED, *second], capture_output=True)
    assert ended.returncode == -signal.SIGKILL
    printed(capsys, *words, "--out", folders[0], "--shard", "1/2")
    assert main(["merge", *folders, "--out", str(tmp_path / "all")]) == 2
    assert (
        f"OUT = '{folders[1]}': must be a folder with a whole shard" in capsys.readouterr().err
    )
    assert main(second) == 0
    assert "goes on: 1 of " in capsys.readouterr().err
    records = printed(capsys, "merge", *folders, "--out", tmp_path / "all", "--json")
    for record in (*whole, *records):
        for name in TIMES:
            record.pop(name, None)
    assert records == whole
    assert runs_of(store.load(tmp_path / "all" / store.FILE)) == runs_of(
        store.load(tmp_path / "0" / store.FILE)
    )
    assert (tmp_path / "all" / "index.html").is_file()


@pytest.mark.rare
def test_the_readme_s_array_job_and_its_matrix_make_one_sweep(tmp_path):
    """The script of a Slurm array with the variables that Slurm sets, and the lines of a matrix of
    GitHub Actions with its numbers, as the README of sweeps has them."""
    import yaml

    text = (ROOT / "engines" / "sweep" / "README.md").read_text("utf-8")
    script, matrix = (
        re.search(rf"```{kind}\n(.*?)```", text, re.DOTALL)[1] for kind in ("sh", "yaml")
    )
    (merge,) = re.findall(r"^    (plumbob merge .*)$", text, re.MULTILINE)
    jobs = yaml.safe_load(matrix)["jobs"]
    line = jobs["shard"]["steps"][0]["run"]
    numbers = jobs["shard"]["strategy"]["matrix"]["number"]
    programs = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"

    def run(folder, command, **variables):
        environment = {**os.environ, "PATH": programs, **variables}
        folder.mkdir(exist_ok=True)
        subprocess.run(command, shell=True, cwd=folder, env=environment, check=True)

    for number in numbers:
        variables = {"SLURM_ARRAY_TASK_ID": str(number), "SLURM_ARRAY_TASK_COUNT": "3"}
        run(tmp_path / "slurm", script, **variables)
        run(tmp_path / "matrix", line.replace("${{ matrix.number }}", str(number)))
    run(tmp_path / "slurm", merge)
    run(tmp_path / "matrix", jobs["whole"]["steps"][1]["run"])
    files = [tmp_path / name / "plumbob-out" / "sweeps.sqlite3" for name in ("slurm", "matrix")]
    slurm, github = (stored_sweeps(file)[0].errors for file in files)
    assert slurm.shape == (1, 1, 25, 6)
    assert np.array_equal(slurm, github, equal_nan=True)
