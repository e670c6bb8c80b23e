"""Pages are drawn from the store alone: no engine, exact motion or theory is loaded for them."""

import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.study import store
from plumbob.engines.study.codec import unstructured
from plumbob.reports.cli import main
from plumbob.reports.records.exact_numbers import exact_numbers_of
from plumbob.reports.records.page_records import PAGES_OF_STUDY, SCENE, records_of
from plumbob.reports.view.site.writing import write_study_pages
from plumbob.tests.commands.outcomes import without_findings
from plumbob.tests.contracts.import_contracts import MOTIONS
from plumbob.tests.support.page_document import site_files
from plumbob.tests.support.stored import save
from plumbob.tests.support.studies import SCENE as NAME
from plumbob.tests.support.studies import quick

REFUSING = f"""
import sys
REFUSED = {MOTIONS!r}
class Refuses:
    @staticmethod
    def find_spec(name, path=None, target=None):
        if any(name == refused or name.startswith(refused + ".") for refused in REFUSED):
            raise ImportError(name + " is refused")
sys.meta_path.insert(0, Refuses)
"""
REPORT = f"{REFUSING}from plumbob.reports.cli import main\nsys.exit(main(sys.argv[1:]))"


def report(out):
    """The index that `plumbob report` writes in a process that refuses to load what it should not
    need."""
    command = [sys.executable, "-c", REPORT, "report", str(out)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    return Path(done.stdout.strip())


def files(index):
    """The content of a site's pages."""
    return {file.name: file.read_bytes() for file in site_files(index)}


@pytest.mark.parametrize("name", MOTIONS)
def test_what_a_page_does_not_need_is_refused(name):
    script = f"{REFUSING}import importlib\nimportlib.import_module({name!r})"
    done = subprocess.run([sys.executable, "-c", script], check=False, capture_output=True)
    assert f"{name} is refused".encode() in done.stderr


def test_report_needs_no_engine_and_no_theory(tmp_path):
    save(quick(), tmp_path / store.FILE)
    drawn = files(write_study_pages(quick(), tmp_path / "here"))
    assert files(report(tmp_path)) == drawn
    assert len(drawn) > len(quick().scenes)


@pytest.mark.long
def test_report_draws_what_validate_drew(tmp_path, monkeypatch, capsys):
    """With an accuracy that was asked for, too, which is an option of `validate` alone."""
    without_findings(monkeypatch)
    chosen = ["--scenes", NAME, "--methods", "mujoco/euler,ode/rk4", "--jobs", "1"]
    assert main(["validate", *chosen, "--within", "1e-9", "--out", str(tmp_path)]) == 1
    drawn = files(tmp_path / "index.html")
    assert "1e-09 was asked for" in drawn[f"{NAME.replace('/', '-')}.html"].decode()
    assert files(report(tmp_path)) == drawn


def test_validate_draws_the_study_that_it_has_and_reads_no_store(tmp_path, monkeypatch):
    def read(*arguments):
        raise AssertionError("a stored result was read")

    without_findings(monkeypatch)
    monkeypatch.setattr(store, "from_json", read)
    chosen = ["--scenes", NAME, "--methods", "ode/rk4", "--jobs", "1", "--out", str(tmp_path)]
    assert main(["validate", *chosen]) == 0
    assert (tmp_path / "index.html").is_file()


def test_a_page_says_what_is_stored(tmp_path):
    """Whatever the code would work out now."""
    kept = "what another version wrote"

    def changed(numbers):
        verdicts = numbers["verdicts"]
        assert isinstance(verdicts, Mapping)
        other = {name: {**verdict, "reason": kept} for name, verdict in verdicts.items()}
        return {**numbers, "verdicts": other}

    analyses = (
        replace(a, numbers=changed(unstructured(a.numbers))) if a.place == SCENE else a
        for a in quick().analyses
    )
    pages = files(write_study_pages(replace(quick(), analyses=tuple(analyses)), tmp_path))
    assert kept in pages[f"{NAME.replace('/', '-')}.html"].decode()


def test_a_page_says_when_its_shipped_numbers_were_computed(tmp_path):
    pages = files(write_study_pages(quick(), tmp_path))
    findings = [a for a in quick().analyses if a.place == "finding"]
    for about in ("cone-pendulum", "engines"):
        shipped = [exact_numbers_of(a.template) for a in findings if a.system == about]
        shipped = [exact for exact in shipped if exact]
        assert shipped
        numbers = ", ".join(f"{name} {value}" for name, value in shipped[0].versions.items())
        said = (
            f"no measurement of this study were computed on {shipped[0].date} with {numbers}."
        )
        assert pages[f"{about}.html"].decode().count(said) == len(shipped)


@pytest.mark.parametrize("place", [SCENE, PAGES_OF_STUDY])
def test_a_store_of_another_version_is_refused_in_a_line(place, tmp_path, capsys):
    kept = tuple(a for a in quick().analyses if a.place != place)
    older = replace(quick(), analyses=kept)
    save(older, tmp_path / store.FILE)
    assert main(["report", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "stored with the numbers of its pages" in said
    other = replace(older, analyses=(*kept, *(_without_a_field(quick(), place))))
    with pytest.raises(ParameterError, match="numbers of its pages"):
        records_of(other)
    assert list(tmp_path.iterdir()) == [tmp_path / store.FILE]


def _without_a_field(study, place):
    """The records of a version that had one number fewer."""
    chosen = [a for a in study.analyses if a.place == place]
    return tuple(
        replace(a, numbers=dict(list(unstructured(a.numbers).items())[1:])) for a in chosen
    )
