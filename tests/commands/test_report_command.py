"""`plumbob report --publish`: a stored study's pages alone."""

from dataclasses import replace

import pytest

from plumbob.engines.study import store
from plumbob.reports.cli import main
from plumbob.reports.commands.report import without_folders
from plumbob.reports.view.own_files import FILE_LIST
from plumbob.tests.support.page_document import Document
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import quick


@pytest.mark.parametrize(
    ("command", "shown"),
    [
        (
            "plumbob validate --scenes 'cone-*' --out /far/away/out --junitxml a/b.xml",
            "plumbob validate --scenes 'cone-*' --out out --junitxml b.xml",
        ),
        (
            "plumbob validate --out=a/b --like 'my models/arm.xml' --methods mujoco/rk4",
            "plumbob validate --out=b --like arm.xml --methods mujoco/rk4",
        ),
        (
            "/far/plumbob validate --ou ../x --junit=~/j.xml",
            "plumbob validate --ou x --junit=j.xml",
        ),
    ],
)
def test_a_published_command_has_no_folders(command, shown):
    assert without_folders(command) == shown


@pytest.mark.long
def test_a_folder_to_publish_is_the_site_without_the_store(tmp_path, capsys):
    """Each link of each page leads to a file in it, and nothing in it is left over."""
    out = tmp_path / "out"
    folder = tmp_path / "public"
    out.mkdir()
    made = replace(quick().provenance, command=f"plumbob validate --out {out}")
    save(replace(quick(), provenance=made), out / store.FILE)
    folder.mkdir()  # an empty one is replaced
    assert main(["report", str(out), "--publish", str(folder)]) == 0
    assert capsys.readouterr().out == f"{folder / 'index.html'}\n"
    assert [path.name for path in out.iterdir()] == [store.FILE]
    assert {path.name for path in tmp_path.iterdir()} == {"out", "public"}
    assert {path.name for path in folder.iterdir()} == {".nojekyll", "index.html", "pages"}
    assert str(out) not in (folder / "index.html").read_text("utf-8")
    led_to = {folder / "index.html", folder / ".nojekyll", folder / "pages" / FILE_LIST}
    for page in folder.rglob("*.html"):
        document = Document(page.read_text("utf-8"))
        named = [*document.links, *document.loaded]
        places = [name.partition("#")[0] for name in named if ":" not in name]
        led_to |= {(page.parent / name).resolve() for name in places if name}
    assert led_to == {path for path in folder.rglob("*") if path.is_file()}
    assert main(["report", str(out), "--publish", str(folder)]) == 2
    assert capsys.readouterr().err.startswith(
        f"plumbob: publish = '{folder}': must be an empty"
    )
