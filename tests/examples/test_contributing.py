"""The examples in the CONTRIBUTING.md files run as they are written there: their files in a copy of
the tree, their commands beside it."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from importlib.util import cache_from_source
from pathlib import Path

import pytest

from plumbob.tests.contracts.tree import PACKAGE, files
from plumbob.tests.support.page_document import site_files

ROOT = Path(__file__).parents[2]
GUIDES = ("CONTRIBUTING.md", "models/CONTRIBUTING.md", "engines/CONTRIBUTING.md")
HEADING = re.compile(r"^## (.+)$", re.MULTILINE)
BLOCK = re.compile(
    r"^(?:In `(?P<tuple>\w+)` of )?`(?P<path>[\w/.]+)`:\n\n"
    r"```(?:python|xml|md)\n(?P<code>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
COMMANDS = re.compile(r"^```sh\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Example:
    """A section of a CONTRIBUTING.md: code by file, what it adds to (or None), and commands."""

    blocks: tuple[tuple[Path, str | None, str], ...]
    commands: tuple[str, ...]


def examples():
    """The examples by the headings of their sections."""
    _, *parts = HEADING.split("".join((ROOT / guide).read_text("utf-8") for guide in GUIDES))
    found = {}
    for heading, text in zip(parts[::2], parts[1::2], strict=True):
        blocks = tuple((Path(m["path"]), m["tuple"], m["code"]) for m in BLOCK.finditer(text))
        commands = tuple(
            line for m in COMMANDS.finditer(text) for line in m[1].splitlines() if line.strip()
        )
        if blocks:
            found[heading] = Example(blocks, commands)
    return found


EXAMPLES = examples()


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the tree with the code of all examples in it."""
    copy = tmp_path_factory.mktemp("examples") / PACKAGE
    for path in files(ROOT):
        if path.parts[0] != "tests":
            (copy / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / path, copy / path)
            _compiled_too(ROOT / path, copy / path)
    for example in EXAMPLES.values():
        for path, group, code in example.blocks:
            if group is None:
                assert not (copy / path).exists()
                (copy / path).parent.mkdir(parents=True, exist_ok=True)
                (copy / path).write_text(code, "utf-8")
            else:
                text = (copy / path).read_text("utf-8")
                assert text.count(f"\n{group} = (\n") == 1
                added = text.replace(f"\n{group} = (\n", f"\n{group} = (\n{code.rstrip()},\n")
                (copy / path).write_text(added, "utf-8")
    return copy


def _compiled_too(path, copied):
    """Bytecode of a module that is there and new enough, which is tested by the copy's time."""
    if path.suffix == ".py":
        compiled, place = (Path(cache_from_source(str(one))) for one in (path, copied))
        if compiled.is_file():
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(compiled, place)


# Commands one after another, each list in a folder of its own, in one process, which loads the
# engines once, and begins no others, which would load them too; without findings but the example's,
# which take longer than all the rest.
IN_TURN = """
import json, os, shlex, sys
from plumbob.reports import analyses
from plumbob.reports.cli import main
os.cpu_count = lambda: 1
section = analyses.section
analyses.section = lambda system: section(system) if system == "double-pendulum" else None
for number, lines in enumerate(json.loads(sys.argv[1])):
    os.mkdir(str(number))
    os.chdir(str(number))
    for line in lines:
        code = main(shlex.split(line)[1:])
        if code:
            sys.exit(f"{line}: {code}")
    os.chdir("..")
"""


def run(tree, where, *command):
    """Output of a command in the folder `where`, with the copy's plumbob; fails with its whole
    output unless it exits with 0."""
    environment = {**os.environ, "PYTHONPATH": str(tree.parent)}
    done = subprocess.run(
        command, cwd=where, env=environment, check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, f"{shlex.join(command)}\n{done.stdout}{done.stderr}"
    return done.stdout


def test_each_kind_of_addition_has_an_example():
    kinds = {"A scene", "A system", "An integrator", "An engine", "A finding"}
    assert set(EXAMPLES) == kinds
    assert all(example.commands for example in EXAMPLES.values())
    system = [code for path, _, code in EXAMPLES["A system"].blocks if path.suffix == ".py"]
    assert len(system) <= 5
    assert sum(code.count("\n") for code in system) <= 250


# The engines that a new system is for, of all that there are adapters for, installed or not.
CLAIMED = """
from plumbob.engines.method import meant
from plumbob.engines.registry import methods
from plumbob.models.registry import matching_scenes
new = matching_scenes("double-pendulum/*")
print(*(m.name for m in methods() if any(meant(m, scene) for scene in new)))
"""


def test_a_new_system_is_for_those_that_build_all_of_its_kind(tree, tmp_path):
    said = run(tree, tmp_path, sys.executable, "-c", CLAIMED)
    own = {"mujoco/euler", "mujoco/rk4", "ode/rk4", "heyoka/taylor"}
    # by the mechanism in the system's model file
    builders = {"pymunk/default", "pymunk/tight", "dart/default", "drake/default"}
    assert own | builders <= {*said.split()}
    assert not any(name.startswith("exact") for name in said.split())


@pytest.mark.long
def test_commands_work(tree, tmp_path):
    commands = [example.commands for example in EXAMPLES.values()]
    assert all(line.startswith("plumbob ") for lines in commands for line in lines)
    run(tree, tmp_path, sys.executable, "-c", IN_TURN, json.dumps(commands))
    out = tmp_path / str(list(EXAMPLES).index("A finding")) / "plumbob-out"
    page = "".join(file.read_text("utf-8") for file in site_files(out / "index.html"))
    page = page.replace("\u00a0", " ")
    assert "The lower rod turns over" in page
    assert "After 10 s it has made 2.5 turns." in page
    # Its drawing comes from its mechanism, without a line of its own.
    assert '<figure class="replay" id="replay-double-pendulum-released"' in page
    assert '<canvas data-system="double-pendulum"' in page


def test_doctests_of_the_examples_run(tree, tmp_path):
    code = "import doctest, importlib, sys; m = importlib.import_module(sys.argv[1]); "
    code += "r = doctest.testmod(m); sys.exit(r.failed or not r.attempted)"
    name = f"{PACKAGE}.analytic.systems.double_pendulum"
    run(tree, tmp_path, sys.executable, "-c", code, name)
