"""Only files that plumbob wrote are replaced: another is named in one line before any work."""

from dataclasses import replace
from pathlib import Path

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.reports.cli import main
from plumbob.reports.commands.shared.several_audits import refused_row, write_badge
from plumbob.reports.view import own_files
from plumbob.reports.view.junit import JunitCase, write_cases
from plumbob.reports.view.own_files import check_replaceable, check_replaceable_folder
from plumbob.reports.view.page import PAGE_TEMPLATES, fill_page
from plumbob.reports.view.site.writing import write_study_pages
from plumbob.tests.support.studies import quick

FOREIGN = "a user's own"
STUDY = ("validate", "--scenes", "linear-pendulum/overdamped", "--methods", "ode/rk4")
SWEEP = ("sweep", "linear-pendulum", "ode/rk4", "--vary", "theta=0.1:0.2:2", "--out", ".")
COMMANDS = {
    "validate, index": ((*STUDY, "--out", "."), "index.html"),
    "validate, pages": ((*STUDY, "--out", "."), "pages/notes.md"),
    "validate, junit": ((*STUDY, "--out", "new", "--junitxml", "my.csv"), "my.csv"),
    "report, index": (("report", "."), "index.html"),
    "report, pages": (("report", "."), "pages/index.html"),
    "report, single": (("report", ".", "--single", "my.html"), "my.html"),
    "compare": (("compare", "old", "new", "--page", "my.html"), "my.html"),
    "stability": (("stability", "linear-pendulum", "ode/rk4", "--out", "."), "stability.html"),
    "sweep": (SWEEP, "map.html"),
    "audit": (("audit", "m.xml", "--out", "."), "audit-m.html"),
    "audit, contacts": (
        ("audit", "m.xml", "--contacts", "--out", "."),
        "audit-m-contacts.html",
    ),
    "audit, reproducible": (
        ("audit", "m.xml", "--reproducible", "--out", "."),
        "audit-m-reproducible.html",
    ),
    "audits": (("audit", "m.xml", "n.xml", "--out", "."), "audit-models.html"),
    "audit, junit": (("audit", "m.xml", "--ctrl", "u.csv", "--junitxml", "u.csv"), "u.csv"),
    "audit, badge": (("audit", "m.xml", "--badge", "m.xml"), "m.xml"),
}


@pytest.mark.parametrize("kind", COMMANDS)
def test_a_file_of_the_users_stays(kind, tmp_path, monkeypatch, capsys):
    words, name = COMMANDS[kind]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "plumbob.reports.view.sweep.page.page_name", lambda sweep, key: "map.html"
    )
    file = Path(name)
    file.parent.mkdir(exist_ok=True)
    file.write_text(FOREIGN)
    assert main(words) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert f"'{name}'" in said.err
    assert file.read_text() == FOREIGN
    assert [path for path in Path().rglob("*") if path.is_file()] == [file]


def test_a_site_is_replaced_with_or_without_its_list(tmp_path):
    """An earlier version made no list."""
    write_study_pages(quick(), tmp_path)
    pages = tmp_path / "pages"
    there = {path.name for path in pages.iterdir()}
    assert {
        *(pages / own_files.FILE_LIST).read_text().splitlines(),
        own_files.FILE_LIST,
    } == there
    (pages / own_files.FILE_LIST).unlink()
    check_replaceable_folder("out", pages)
    for name in ("foreign.svg", "foreign.html", "folder"):
        file = pages / name
        file.mkdir() if name == "folder" else file.write_text(FOREIGN)
        with pytest.raises(ParameterError, match=name):
            check_replaceable_folder("out", pages)
        file.rmdir() if name == "folder" else file.unlink()
    write_study_pages(quick(), tmp_path)
    (pages / "foreign.svg").write_text(FOREIGN)
    with pytest.raises(ParameterError, match=r"foreign\.svg"):
        write_study_pages(replace(quick(), profile="full"), tmp_path)
    assert (pages / "foreign.svg").read_text() == FOREIGN


def _junit(file):
    write_cases(file, [JunitCase("a", "b", 0.0, {})], 0.0, "")


def _badge(file):
    write_badge(file, [refused_row("m.xml", "a reason")], False)


def _page(file):
    file.write_text(fill_page("frame.html.jinja"), "utf-8")


@pytest.mark.parametrize("write", [_junit, _badge, _page, Path.touch])
def test_what_plumbob_wrote_bears_its_mark(write, tmp_path):
    """An empty file holds nothing that could be lost."""
    file = tmp_path / "file"
    write(file)
    assert check_replaceable("file", file) == file
    file.write_bytes(b" " * own_files.HEAD + file.read_bytes())
    with pytest.raises(ParameterError, match="one that plumbob wrote"):
        check_replaceable("file", file)


def test_every_page_has_the_mark_in_its_title():
    titled = [file for file in PAGE_TEMPLATES.glob("*.jinja") if "<title>" in file.read_text()]
    assert [file.name for file in titled] == ["frame.html.jinja"]
    for file in PAGE_TEMPLATES.glob("*.html.jinja"):
        _, title, rest = file.read_text("utf-8").partition("block title %}")
        assert not title or "plumbob" in rest.partition("{% endblock")[0], file


@pytest.mark.parametrize("kind", ["dangling link", "folder", "link to a folder"])
def test_what_is_no_file_stays(kind, tmp_path):
    place = tmp_path / "place"
    if kind == "folder":
        place.mkdir()
    else:
        place.symlink_to(tmp_path / "nothing" if kind == "dangling link" else tmp_path)
    with pytest.raises(ParameterError, match="place"):
        check_replaceable("out", place)
    if kind != "folder":
        with pytest.raises(ParameterError, match="place"):
            check_replaceable_folder("out", place)
