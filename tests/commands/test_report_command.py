"""`plumbob report`: a stored study's page, the same to the byte, without any engine."""

import subprocess
import sys

import pytest

from plumbob.reports.cli import main
from plumbob.tests.support.page_document import Document

# Two systems with recordings of each engine, whose findings need few runs of their own.
SCENES = "linear-pendulum/overdamped,capsule-coast/translation"
METHODS = "mujoco/euler,pymunk,ode/rk4"
WITHOUT_ENGINES = """
import sys
sys.modules["mujoco"] = sys.modules["pymunk"] = None  # as if they were not installed
from plumbob.reports.cli import main
sys.exit(main(["report", *sys.argv[1:]]))
"""


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study") / "out"
    words = ["--scenes", SCENES, "--methods", METHODS, "--out", str(folder), "--jobs", "1"]
    assert main(["validate", *words]) == 0
    return folder


@pytest.mark.long
def test_the_page_is_the_same_to_the_byte_without_engines(out):
    page = out / "index.html"
    written = page.read_bytes()
    page.unlink()
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_ENGINES, str(out)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, f"{page}\n"), done.stderr
    assert page.read_bytes() == written


@pytest.mark.long
def test_a_folder_to_publish_is_the_site_without_the_store(out, tmp_path, capsys):
    """Each link of each page leads to a file in it, and nothing in it is left over."""
    before = {path.name for path in out.iterdir()}
    folder = tmp_path / "public"
    folder.mkdir()  # an empty one is replaced
    assert main(["report", str(out), "--publish", str(folder)]) == 0
    assert capsys.readouterr().out == f"{folder / 'index.html'}\n"
    assert {path.name for path in out.iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["public"]
    assert {path.name for path in folder.iterdir()} == {".nojekyll", "index.html", "pages"}
    led_to = {folder / "index.html", folder / ".nojekyll"}
    for page in folder.rglob("*.html"):
        document = Document(page.read_text("utf-8"))
        named = [*document.links, *document.loaded]
        places = [name.partition("#")[0] for name in named if ":" not in name]
        led_to |= {(page.parent / name).resolve() for name in places if name}
    assert led_to == {path for path in folder.rglob("*") if path.is_file()}
    assert main(["report", str(out), "--publish", str(folder)]) == 2
    assert capsys.readouterr().err.startswith(f"plumbob: publish = '{folder}': must be an empty")
