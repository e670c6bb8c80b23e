"""What `plumbob models export` writes works where it lands, with nothing but MuJoCo installed."""

import re
import subprocess
import sys

import pytest

from plumbob.models.registry import systems
from plumbob.reports.cli import main

WITHOUT = """import sys
sys.modules |= dict.fromkeys(["plumbob", "scipy", "pymunk", "mpmath", "plotly"])  # not importable
"""
INDENTED = re.compile(r"(?:^    .*\n|^\n(?=\n?    ))+", re.MULTILINE)
SHOWN = re.compile(r"  # (.+)$", re.MULTILINE)  # after a line that prints
NAMED = re.compile(r"`([\w.-]+(?:/[\w.-]+)*[.](?:py|xml|md|png|cff))`|[]][(]([^)]+)[)]")
COMMAND = re.compile(r"^    python -m mujoco.viewer --mjcf=(.+)$", re.MULTILINE)
FOLDERS = sorted({system.mjcf.parent.name for system in systems().values()})
TEXTS = ("README.md", *(f"{folder}/README.md" for folder in FOLDERS))


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    target = tmp_path_factory.mktemp("exported") / "models"
    assert main(["models", "export", str(target)]) == 0
    return target


def scripts(text):
    blocks = [
        "".join(line[4:] or "\n" for line in m[0].splitlines(True))
        for m in INDENTED.finditer(text)
    ]
    return [block for block in blocks if "import mujoco\n" in block]


@pytest.mark.long
@pytest.mark.parametrize("name", TEXTS)
def test_a_script_prints_what_it_says(exported, name):
    (script,) = scripts((exported / name).read_text("utf-8"))
    line = [sys.executable, "-I", "-W", "error", "-c", WITHOUT + script]
    ran = subprocess.run(line, cwd=(exported / name).parent, capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (0, "")
    said = [m[1] for row in script.splitlines() if "print(" in row and (m := SHOWN.search(row))]
    assert said or name == "README.md"
    assert set(said) == set(ran.stdout.splitlines()) or name == "README.md"
    if name == "README.md":
        files = [str(path.relative_to(exported)) for path in sorted(exported.glob("*/*.xml"))]
        assert [row.partition(":")[0] for row in ran.stdout.splitlines()] == files


@pytest.mark.parametrize("name", TEXTS)
def test_what_a_text_names_is_there(exported, name):
    text = (exported / name).read_text("utf-8")
    folder = (exported / name).parent
    named = [one or other for one, other in NAMED.findall(text)]
    assert named
    for file in [*named, *COMMAND.findall(text)]:
        assert (folder / file).is_file(), file
