"""Packages with entry points, installed for one test: a folder on the path with their modules and
their metadata, as pip leaves them."""

import sys
import tomllib
from contextlib import contextmanager
from pathlib import Path

import pytest

from plumbob.engines import registry as engines
from plumbob.models import entry_points
from plumbob.models import registry as models

PACKAGES = Path(__file__).parent / "packages"
DEFECTS = tomllib.loads((Path(__file__).parent / "defects.toml").read_text("utf-8"))
ENGINE = (PACKAGES / "tiny_engine" / "tiny_engine.py").read_text("utf-8")


def install(site, name, points, **modules):
    """Install the package `name`, version 1.0, in the folder `site`: its entry points by group and
    name, and its modules by name."""
    metadata = site / f"{name.replace('-', '_')}-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", "utf-8"
    )
    lines = []
    for group, values in points.items():
        lines += [f"[{group}]", *(f"{key} = {value}" for key, value in values.items())]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n", "utf-8")
    for module, text in modules.items():
        (site / f"{module}.py").write_text(text, "utf-8")


def install_folder(site, folder):
    """Install one of the packages beside the tests as its pyproject.toml says."""
    project = tomllib.loads((PACKAGES / folder / "pyproject.toml").read_text("utf-8"))
    modules = project["tool"]["setuptools"]["py-modules"]
    texts = {m: (PACKAGES / folder / f"{m}.py").read_text("utf-8") for m in modules}
    install(site, project["project"]["name"], project["project"]["entry-points"], **texts)


def broken(site, text, group=entry_points.ENGINES, name="tiny"):
    """Install a package that adds `name` with a module of this text."""
    what = "ENGINE" if group == entry_points.ENGINES else "SYSTEM"
    install(site, "their-package", {group: {name: f"theirs:{what}"}}, theirs=text)


def changed(text, right, wrong):
    """The text of a module with one piece of it replaced."""
    assert right in text
    return text.replace(right, wrong)


@contextmanager
def seen(site):
    """Let this process see the packages of the folder `site`, and forget them afterwards."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(site))
        _forget(site)
        try:
            yield
        finally:
            _forget(site)
    _forget(site)


def _forget(site):
    for kept in (
        entry_points.entry_points_by_name,
        entry_points.additions,
        engines.engines,
        models.systems,
        models._cached_case,
    ):
        kept.cache_clear()
    for name in [n for n, m in sys.modules.items() if _inside(m, site)]:
        del sys.modules[name]


def _inside(module, site):
    return str(getattr(module, "__file__", None) or "").startswith(str(site))
