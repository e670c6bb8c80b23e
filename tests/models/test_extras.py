"""Hints on what to install work from a clone and from a wheel: they name packages on an index."""

from importlib import metadata
from pathlib import Path

import pytest

from plumbob.models import extras
from plumbob.tests.contracts.tree import files

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("extra", "packages"),
    [
        ("robots", "'gymnasium[mujoco]>=1.0'"),
        ("distributed", "'dask[distributed]>=2025.1'"),
        ("none", "'.[none]' in plumbob's folder"),
    ],
)
def test_a_hint_names_the_packages(extra, packages):
    assert extras.install_command(extra) == f"pip install {packages}"


def test_a_copy_without_metadata_names_its_folder(monkeypatch):
    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(extras.metadata, "requires", missing)
    assert extras.install_command("robots") == "pip install '.[robots]' in plumbob's folder"


def test_no_text_has_a_command_that_asks_an_index_for_plumbob():
    """An extra of plumbob by its name is found on no index."""
    asked = "pip install 'plumb" + "ob["
    texts = [path for path in files(ROOT) if path.suffix in (".py", ".md", ".toml", ".jinja")]
    assert [str(path) for path in texts if asked in (ROOT / path).read_text("utf-8")] == []
