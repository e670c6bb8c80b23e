"""The wheel holds what the package needs and no more; every dependency has a lower bound."""

import configparser
import shutil
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

from plumbob.tests.contracts.tree import LAYERS, PACKAGE, files

ROOT = Path(__file__).parents[2]
PLANTED = {  # kinds of file that a layer may come to hold
    "engines": ("*.md",),
    "models": ("*.xml", "*.md", "*.png"),
    "reports": ("*.md", "*.html", "*.css", "*.svg", "*.jinja", "*.js", "*.json"),
}


def project():
    """The project's own description."""
    table = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    return table


def requirements():
    """What plumbob requires, with every extra."""
    extras = project()["optional-dependencies"].values()
    return [Requirement(line) for line in sum(extras, project()["dependencies"])]


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A copy of the tree, with a file of every kind planted deep in its layer."""
    copy = tmp_path_factory.mktemp("source")
    for path in files(ROOT):
        (copy / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / path, copy / path)
    for layer, patterns in PLANTED.items():
        (copy / layer / "deep" / "er").mkdir(parents=True)
        for pattern in patterns:
            (copy / layer / "deep" / "er" / pattern.replace("*", "planted")).write_text(
                "planted"
            )
    return copy


@pytest.fixture(scope="module")
def wheel(source):
    """The wheel, built from the copy."""
    if Version(version("setuptools")) < Version("77"):
        pytest.skip("needs the setuptools of the extra 'test', and this environment's is older")
    build = "from setuptools.build_meta import build_wheel; build_wheel('dist')"  # as pip does
    subprocess.run([sys.executable, "-c", build], cwd=source, check=True, capture_output=True)
    (built,) = (source / "dist").glob("plumbob-*.whl")
    return zipfile.ZipFile(built)


@pytest.mark.long
def test_wheel_holds_the_package_and_nothing_else(source, wheel):
    inside = {name for name in wheel.namelist() if ".dist-info/" not in name}
    root = {
        "CITATION.cff",
        "LICENSE",
        "SKILL.md",
        "__init__.py",
        "__main__.py",
        "py.typed",
    }  # with models
    ours = {p.as_posix() for p in files(source) if p.parts[0] in LAYERS or p.as_posix() in root}
    assert inside == {f"{PACKAGE}/{path}" for path in ours}
    assert f"{PACKAGE}/reports/deep/er/planted.jinja" in inside


def test_package_list_is_the_tree():
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["setuptools"]
    folders = {path.parent for path in files(ROOT) if path.name == "__init__.py"}
    found = {".".join((PACKAGE, *folder.parts)) for folder in folders}
    assert set(listed["packages"]) == found


@pytest.mark.long
def test_wheel_has_the_command_and_the_licence(wheel):
    (entry,) = (name for name in wheel.namelist() if name.endswith("/entry_points.txt"))
    points = configparser.ConfigParser()
    points.read_string(wheel.read(entry).decode())
    assert dict(points["console_scripts"]) == {"plumbob": "plumbob.__main__:main"}
    assert any(name.endswith("/licenses/LICENSE") for name in wheel.namelist())


@pytest.mark.parametrize("requirement", requirements(), ids=str)
def test_dependency_has_a_lower_bound(requirement):
    assert [specifier.operator for specifier in requirement.specifier] == [">="]


def test_constraints_are_within_the_bounds():
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    pins = {
        pin.name: str(pin.specifier).removeprefix("==")
        for pin in (Requirement(line) for line in lines if line and not line.startswith("#"))
    }
    assert pins["mujoco"] == "3.17.0"
    bounds = {requirement.name: requirement.specifier for requirement in requirements()}
    assert {name for name, version in pins.items() if version not in bounds[name]} == set()


def test_citation_names_the_version():
    citation = (ROOT / "CITATION.cff").read_text("utf-8")
    assert f"\nversion: {project()['version']}\n" in citation
