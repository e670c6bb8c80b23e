"""Every command in README.md and the texts that it links to runs as it is written there."""

import re
import shutil
from pathlib import Path

import pytest

from plumbob.engines.registry import methods as find_methods
from plumbob.reports.cli import main
from plumbob.reports.commands import recommend
from plumbob.tests.commands.outcomes import without_findings
from plumbob.tests.commands.test_recommend_command import FEW
from plumbob.tests.contracts.tree import LAYERS, files
from plumbob.tests.support.first_verdicts import without_first_verdict
from plumbob.tests.support.page_document import resolve, words
from plumbob.tests.validation.readme_picture import FILE, picture

ROOT = Path(__file__).parents[2]
READMES = (  # all indented commands of these run, in this order
    "README.md",
    "reports/commands/README.md",
    "engines/README.md",
    "engines/adapters/mujoco/README.md",
    "engines/audit/README.md",
    "engines/sweep/README.md",
    "reports/judge/README.md",
    "reports/analyses/README.md",
)
TEXTS = (
    *READMES,
    "engines/adapters/README.md",
    "models/tripod_capsule/README.md",
    "analytic/errors/THEORY.md",
)
MOST_LINES = 160  # of README.md
QUESTION = re.compile(r"^\d[.] [*]{2}.+[?][*]{2}", re.MULTILINE)
LINK = re.compile(r"\]\(([^):]+)\)")
INDENTED = re.compile(r"^    (plumbob|make|git) (.+)$", re.MULTILINE)
PLAIN = re.compile(r"`(plumbob [a-z][^`]*)`")
PYTHON = re.compile(r"^    from plumbob import check\n(?:    .+\n)+", re.MULTILINE)
ABRIDGED = re.compile(r"\b(METHOD|DT|DIR|OUT|FILE|X Y PSI|validate|compare)\b")
# What is not run here, and why; all but the first three are read, and their names looked up.
NOT_RUN = {
    "git clone <this repository> plumbob && cd plumbob": "the repository is here",
    "make validate": "the whole study: minutes; .ci/run does it",
    "make test": "this is part of it",
    "plumbob validate --like my.xml": "every quick scene: test_like_command.py does a part",
    "plumbob recommend simple-pendulum/free-large --error 1e-6 --like my.xml": (
        "every method of the scene: half a minute; test_like_command.py does a part"
    ),
    "plumbob recommend 'capsule-line/heading-*' --error 1e-3": (
        "24 scenes: minutes; test_recommend_command.py asks for a smaller family"
    ),
    "plumbob run simple-pendulum/free-large mjwarp/default --step 0.01 --worlds 1,512,8192": (
        "a package that may be missing: tests/peers/test_smooth_peers.py"
    ),
    **dict.fromkeys(
        (
            "plumbob merge shard-1 shard-2 --out plumbob-out",
            "plumbob merge shard-1 shard-2 shard-3 --out plumbob-out",
        ),
        "shards are needed: tests/study/test_shards.py",
    ),
    "plumbob audit my.xml": "seconds of every core: tests/audit does it on small models",
    **dict.fromkeys(
        (
            "plumbob run my.xml mujoco/rk4 --step 1e-3",
            "plumbob run my.xml drake/default --ctrl sines",
            "plumbob recommend my.xml --error 1e-3",
            "plumbob gradient my.xml drake/default",
            "plumbob gradient my.xml --of slider --by control",
            "plumbob stability my.xml",
            "plumbob stability my.xml mujoco/rk4 drake/default",
        ),
        "up to a minute each: tests/commands/test_own_file.py does it on a small model",
    ),
    "plumbob audit my.xml theirs --jobs 2": "seconds a model: test_several_audits.py has its own",
    "plumbob audit my.xml --write-fixed fixed.xml": (
        "seconds of every core: tests/audit/test_fixed_file.py does it on small models"
    ),
    "plumbob audit half_cheetah.xml --ctrl sines --write-fixed fixed.xml": (
        "a file of another package: tests/audit/test_fixed_file.py has it"
    ),
    "plumbob audit half_cheetah.xml --ctrl sines": "a file of another package",
    "plumbob audit half_cheetah.xml --ctrl sines --engines all": (
        "a file of another package: tests/peers/test_engines_of_audits.py has its own"
    ),
    "plumbob identify capsule-line/heading-030 mujoco/euler --parameter friction --way sysid": (
        "packages that may be missing: tests/sweep/test_identify.py"
    ),
    "plumbob stability simple-pendulum/free-large mujoco/euler ode/rk4 --long --step 0.02": (
        "seconds: test_stability_command.py has a shorter one"
    ),
    **dict.fromkeys(
        (
            "plumbob releases my.xml --versions '>=3.8' --bisect",
            "plumbob releases my.xml --versions '>=3.8' --bisect --fail-above 5%",
            "plumbob releases simple-pendulum --versions '>=3.14'",
        ),
        "an index of packages: tests/releases has releases of its own",
    ),
    "plumbob audit my.xml --holds --keyframe grip --creep-within 1e-6": (
        "a keyframe of one's own: tests/audit/contacts/test_holds_command.py"
    ),
    "plumbob settings for my.xml --pair ball floor --creep 1e-6": (
        "geoms of one's own: tests/mujoco/test_settings_for_contacts.py"
    ),
    "plumbob audit my.xml --reproducible": "seconds: test_reproducible.py has a smaller model",
    "plumbob difference a.npz b.npz --model my.xml": "test_difference_command.py makes recordings",
    "plumbob difference a.npz --model my.xml": "the same with one recording",
    "plumbob audit my.xml --json > old.json": "seconds, and a shell's: test_audit_changes.py",
    "plumbob audit my.xml --against old.json --fail-above 5%": "the same with a file before",
    "plumbob audit --gym HalfCheetah-v5 --seed 3 --policy my_policies:act --in-the-loop "
    "--episodes 24": "another package: tests/audit/test_gym_returns.py",
    "plumbob stability my.xml --policy my_policies:act --ctrl-period 0.02 --delay 0.01": (
        "a policy of one's own: tests/audit/test_loop_stability.py"
    ),
    **dict.fromkeys(
        (
            "plumbob audit my.xml --policy my_policies:act --in-the-loop",
            "plumbob audit my.xml --policy my_policies:act --in-the-loop --ctrl-period 0.02",
            "plumbob audit my.xml --policy my_policies:act --in-the-loop --episodes 24 "
            "--metric my_policies:score",
            "plumbob audit my.xml --policy my_policies:act --in-the-loop --episodes 24 "
            "--metric my_policies:score --return-within 2%",
        ),
        "a policy of one's own: tests/audit/test_audit_in_the_loop.py and test_episodes.py",
    ),
    "plumbob stability servo/held-half mujoco/euler --step 0.05": (
        "seconds: tests/closed_forms/test_held_loop.py does it"
    ),
    "plumbob audit go2/scene_flat.xml --contacts --keyframe home --friction 0.3": (
        "a file of another package"
    ),
    "plumbob view capsule-line": "a window: tests/commands/test_view_command.py",
    "plumbob view my.xml --gif my.gif --ctrl sines": "a renderer: test_view_command.py has its own",
    "plumbob plan --to 0.3 0.1 3.14": "the same with --method plans it, and runs it",
}


def commands(text):
    """The commands in the indented blocks of a text, each once, without their comments."""
    found = [f"{m[1]} {m[2]}" for m in INDENTED.finditer(text)]
    return list(dict.fromkeys(command.partition("  #")[0].rstrip() for command in found))


README = (ROOT / "README.md").read_text("utf-8")


def test_the_readme_is_short_asks_first_and_leads_to_all_others():
    assert len(README.splitlines()) <= MOST_LINES
    assert len(QUESTION.findall(README.partition("\n## Commands")[0])) == 5
    others = {
        p.as_posix() for p in files(ROOT) if p.name == "README.md" and p.parts[0] in LAYERS
    }
    assert others <= set(LINK.findall(README))
    assert set(READMES) <= {"README.md", *others}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where a user works: with a model file of their own, here the model that is exported."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "models" / "tripod_capsule", tmp_path / "theirs")
    model = (tmp_path / "theirs" / "tripod_capsule.xml").read_text("utf-8")
    (tmp_path / "my.xml").write_text(model, "utf-8")
    return tmp_path


@pytest.mark.long
def test_every_command_runs_as_it_is_written(folder, capsys, monkeypatch):
    """In their order, in one folder, and in this process, for others take longer to begin than to
    run: each ends with exit code 0 and says nothing on stderr. Without findings, which have tests
    of their own, and with few methods to recommend."""
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    monkeypatch.setattr(recommend, "find_methods", lambda: find_methods(FEW))
    without_findings(monkeypatch)
    given = commands("".join((ROOT / name).read_text("utf-8") for name in READMES))
    assert set(NOT_RUN) <= set(given)
    for command in given:
        if command in NOT_RUN:
            if command.startswith("plumbob"):
                resolve(command.partition(" > ")[0], folder)
            continue
        _prepare(command, folder)
        assert main(words(command)) == 0, f"{command}\n{capsys.readouterr().err}"
        out, err = capsys.readouterr()
        assert (bool(out), without_first_verdict(err)) == (True, ""), command


def _prepare(command, folder):
    """What a command needs that no other has made: an older study to compare with."""
    if "old-out" in command:
        shutil.copytree(folder / "plumbob-out", folder / "old-out")


def test_the_python_example_runs():
    (example,) = PYTHON.findall(README)
    code = "\n".join(line.strip() for line in example.splitlines())
    assert code.count("check(") == 2
    exec(code, {})


@pytest.mark.parametrize("name", TEXTS)
def test_commands_within_sentences_can_be_read(name, folder):
    for command in PLAIN.findall((ROOT / name).read_text("utf-8")):
        if not ABRIDGED.search(command):
            resolve(" ".join(command.split()), folder)


def test_the_picture_is_what_its_command_draws():
    """Errors of runs, in tenths of a pixel: the same on every machine."""
    assert FILE.read_text("utf-8") == picture()
