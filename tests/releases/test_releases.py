"""`plumbob releases` over planted releases of pymunk, which pip installs from a folder."""

import json
from importlib import metadata

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.releases.overlays import chosen_versions
from plumbob.reports.cli import main
from plumbob.tests.releases.planted import write_wheel

SCENE = "projectile/thrown"
# pymunk's steps are a thousandth too long from the second release on.
PLANTED = {"99.1": 1.0, "99.2": 1.001, "99.3": 1.001}


@pytest.fixture(name="index", scope="module")
def _index(tmp_path_factory):
    """A folder of wheels from which pip installs, in place of an index."""
    folder = tmp_path_factory.mktemp("wheels")
    for version, factor in PLANTED.items():
        write_wheel(folder, version, factor)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PIP_NO_INDEX", "1")
        patch.setenv("PIP_FIND_LINKS", str(folder))
        patch.setenv("PIP_CONFIG_FILE", "/dev/null")
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        yield folder


def releases(out, *more):
    """The exit code of the command on one scene of pymunk."""
    words = ["releases", SCENE, "--engine", "pymunk"]
    return main([*words, "--out", str(out), "--jobs", "2", "--json", *more])


@pytest.fixture(name="out", scope="module")
def _out(tmp_path_factory):
    """The folder of the results of all tests: a release is measured once."""
    return tmp_path_factory.mktemp("out")


def test_bisection_names_the_release(index, out, capfd):
    """Its results are kept, and what is installed for the user stays as it is."""
    before = {package.name: package.version for package in metadata.distributions()}
    chosen = ["--versions", ">=99", "--bisect", "--fail-above", "1%"]
    assert releases(out, *chosen) == 1
    answer = json.loads(capfd.readouterr().out)
    assert (answer["first"]["outcome"], answer["first"]["version"]) == ("moved", "99.2")
    assert answer["first"]["before"] == "99.1"
    assert "99.2" in (out / "releases.html").read_text("utf-8")
    kept = {path: path.stat().st_mtime_ns for path in out.rglob("studies.sqlite3")}
    assert len(kept) == 3
    assert releases(out, *chosen) == 1
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert {package.name: package.version for package in metadata.distributions()} == before


def test_a_release_that_is_missing_costs_its_column(index, out, capfd):
    assert releases(out, "--versions", "99.1,99.7") == 3
    answer = json.loads(capfd.readouterr().out)
    measured, missing = answer["releases"]
    assert (measured["why"], measured["bytes"] > 1e6) == ("", True)
    assert "99.7" in missing["why"]
    assert [row["cells"][1] for row in answer["rows"]] == ["–"]


@pytest.mark.parametrize("text", ["", "abc", ">=1000", "3.1,abc", "=="])
def test_versions_that_are_none_are_refused(index, tmp_path, text):
    with pytest.raises(ParameterError, match="versions"):
        chosen_versions(text, "pymunk", tmp_path)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing.xml"], "subject"),
        (["no-such/scene"], "no-such/scene"),
        (["--engine", "bullet4"], "engine"),
        (["--engine", "pymunk", __file__], "subject"),
    ],
)
def test_wrong_questions_are_refused(index, tmp_path, capfd, words, said):
    """Before any release is installed, in one line."""
    assert main(["releases", *words, "--versions", "99.1", "--out", str(tmp_path / "o")]) == 2
    line = capfd.readouterr().err
    assert said in line
    assert line.count("\n") == 1
    assert not (tmp_path / "o").exists()
