"""The pages load nothing from elsewhere, are written whole, and show what was measured."""

import html
import re
from dataclasses import replace
from pathlib import Path

import pytest
from jinja2 import TemplateNotFound

from plumbob.analytic.schemes import RK4, Scheme
from plumbob.engines.method import Method
from plumbob.engines.study.provenance import Provenance
from plumbob.engines.study.results import Analysed
from plumbob.models.registry import scene as find_scene
from plumbob.reports.cli import main
from plumbob.reports.view.site import writing
from plumbob.reports.view.site.writing import (
    site_content,
    site_in_one_file,
    write_site,
    write_study_pages,
)
from plumbob.tests.site.whole_profile import small
from plumbob.tests.support.page_document import (
    Document,
    broken_links,
    plotted,
    resolve,
    site_files,
    words,
)
from plumbob.tests.support.studies import made_up, quick, recorded, remeasured

KILOBYTES = 260.0  # of an index, without the files that it shares
HOSTILE = "<script>alert('x')</script><img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return write_site(small(), tmp_path_factory.mktemp("page") / "new")


@pytest.fixture(scope="module")
def documents(page):
    return {file: Document(file.read_text("utf-8")) for file in site_files(page)}


def test_an_index_and_a_folder(page):
    (folder,) = (path for path in page.parent.iterdir() if path.is_dir())
    assert {path.name for path in page.parent.iterdir()} == {"index.html", folder.name}
    assert page.stat().st_size < KILOBYTES * 1e3
    assert {"page.css", "page.js", "plotly.js"} <= {path.name for path in folder.iterdir()}
    assert {f"{scene.name.replace('/', '-')}.html" for scene in quick().scenes} <= {
        path.name for path in folder.iterdir()
    }


def test_they_load_nothing_from_elsewhere(documents):
    for file, document in documents.items():
        loaded = [name for name in document.loaded if not name.startswith("data:image/svg")]
        files = {Path(name).name for name in loaded}
        pictures = {name for name in files if re.fullmatch(r"[0-9a-f]{12}\.svg", name)}
        known = {"page.css", "page.js", "icon.svg", "plotly.js", "search.js"}
        known |= {f"{file.stem}.js"} if plotted(file) else set()
        known |= {n for n in files if n.startswith("replay-") or n == "thumbnails.js"}
        assert files - {"cone_pendulum.png"} - pictures == known
        least = {"engines": 1, "audit": 2}.get(file.stem, 4)
        assert len(pictures) >= least or not plotted(file)
        assert all((file.parent / name).is_file() for name in loaded)


def test_every_link_leads_somewhere(documents):
    assert broken_links(documents) == []
    (first, *_) = documents
    text = first.read_text("utf-8")
    for broken in (text.replace(".html#", ".html#no-"), text.replace('id="top"', 'id="use"')):
        assert broken_links({**documents, first: Document(broken)}) != []


def test_every_scene_method_and_number_is_in_a_table(documents):
    study = quick()
    said = " ".join(" ".join(one.cells) for one in documents.values())
    for scene in study.scenes:
        assert scene.name in said
    for method in study.methods:
        assert method.name in said
    for name in ("predicted", "19.655093168750", "13.389704809267", "19.729447983"):
        assert name in said
    (cone,) = (d for f, d in documents.items() if f.name == "cone-pendulum-rotating-base.html")
    assert "transition" in cone.cells  # derivatives, way by way
    assert not re.search(r"\de\+\d", " ".join(cone.cells))  # 280, not 2.8e+02


def test_commands_on_the_pages_run(page, capsys):
    """Each can be read, and what it names is there; the shortest of each cheap kind runs."""
    text = "".join(file.read_text("utf-8") for file in site_files(page))
    assert not re.search(r"<(?:p|dd)[^>]*>[^<]*`", text)  # which is no way to mark a command
    shown = sorted(set(re.findall(r"<code>(plumbob .*?)</code>", text.replace("<wbr>", ""))))
    kinds = {}
    for command in map(html.unescape, shown):
        resolve(command, page.parent)
        kinds.setdefault(words(command)[0], []).append(command)
    kinds_shown = {"validate", "solve", "run", "settings", "recommend", "models", "stability"}
    assert set(kinds) == kinds_shown | {"gradient", "audit"}
    for kind in ("solve", "run", "settings"):
        assert main(words(min(kinds[kind], key=len))) == 0
        assert capsys.readouterr().err == ""


def test_markup_from_outside_is_escaped(tmp_path):
    study = made_up([(Method("made/up", Scheme(RK4), 4), (1e-3, 1e-4), lambda h: h)])
    scene = replace(study.scenes[0], summary=HOSTILE)
    hostile = recorded(
        replace(
            remeasured(study, lambda m: replace(m, status="diverged", reason=HOSTILE)),
            scenes=(scene,),
            costs={},
            provenance=Provenance(command=HOSTILE),
        )
    )
    index = write_study_pages(hostile, tmp_path)
    for text in (
        *(file.read_text("utf-8") for file in site_files(index)),
        site_in_one_file(site_content(hostile)),
    ):
        tags = [tag for tag in re.findall(r"<img[^>]*>", text) if "loading=" not in tag]
        assert tags == []
        assert HOSTILE not in text
    assert any("onerror" in file.read_text("utf-8") for file in site_files(index))


def test_nothing_is_half_written(tmp_path):
    broken = Analysed("no/such/template", "finding", "cone-pendulum", "", {})
    old = tmp_path / "index.html"
    old.write_text("old", "utf-8")
    with pytest.raises(TemplateNotFound, match="no/such/template"):
        write_study_pages(replace(quick(), analyses=(*quick().analyses, broken)), tmp_path)
    assert [path.read_text("utf-8") for path in tmp_path.iterdir()] == ["old"]


def test_an_engine_that_is_not_installed_is_a_line(tmp_path):
    """Its methods have no row each, in any table, and no curve."""
    ran = Method("made/up", Scheme(RK4), 4)
    gone = [Method(f"absent/{name}", Scheme(RK4), 4) for name in ("one", "two")]
    study = made_up([(method, (1e-3, 1e-4), lambda h: h) for method in (ran, *gone)])

    def lacking(m):
        absent = m.method.startswith("absent")
        return replace(m, status="missing", errors={}) if absent else m

    index = write_study_pages(recorded(remeasured(study, lacking)), tmp_path)
    page = next(f for f in site_files(index) if f.stem == "cone-pendulum-rotating-base")
    text = page.read_text("utf-8")
    assert text.count("absent") == 1
    assert "Not run, because not installed: absent (2 methods)." in text


def _small(study_step=1e-3):
    return recorded(
        made_up([(Method("made/up", Scheme(RK4), 4), (study_step, 1e-4), lambda h: h)])
    )


def test_the_old_site_is_whole_until_the_new_one_is_there(tmp_path, monkeypatch):
    index = write_study_pages(_small(), tmp_path)
    before = {file: file.read_bytes() for file in site_files(index)}
    with monkeypatch.context() as patched:
        patched.setattr(writing, "fill_page", _full)
        with pytest.raises(OSError, match="no space"):
            write_study_pages(_small(2e-3), tmp_path)
    assert {file: file.read_bytes() for file in site_files(index)} == before
    (tmp_path / "other").mkdir()
    style = tmp_path / "pages" / "page.css"
    style.write_text("broken", "utf-8")
    write_study_pages(_small(2e-3), tmp_path)
    assert index.read_bytes() != before[index]
    assert style.read_text("utf-8") != "broken"
    assert {path.name for path in tmp_path.iterdir()} == {"pages", "other", "index.html"}


def _full(*_, **more):
    raise OSError("no space left")


def test_a_system_that_no_method_is_meant_for_has_no_page(tmp_path):
    study = made_up([(Method("made/up", Scheme(RK4), 4), (1e-3, 1e-4), lambda h: h)])
    more = replace(study, scenes=(*study.scenes, find_scene("servo/joint-damped")))
    files = site_files(write_study_pages(recorded(more), tmp_path))
    assert broken_links({f: Document(f.read_text("utf-8")) for f in files}) == []
    assert {"cone-pendulum", "servo"} & {f.stem for f in files} == {"cone-pendulum"}
