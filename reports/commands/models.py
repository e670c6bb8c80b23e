"""plumbob models: the MJCF models, and a copy of them for your own use."""

from __future__ import annotations

import argparse
import filecmp
import os
import shutil
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.models.registry import systems


def arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    actions = parser.add_subparsers(metavar="ACTION", dest="action")
    export = actions.add_parser("export", help="copy the models' folders into DIR")
    export.add_argument("dir", metavar="DIR")


def command(chosen: argparse.Namespace) -> int:
    """Print where the models are, or copy them; what is there already is not written over."""
    folders = sorted({system.mjcf.parent for system in systems().values()})
    if chosen.action != "export":
        for folder in folders:
            print(f"{folder.name}  {folder}")
        return 0
    target = Path(chosen.dir)
    files = [
        (path, target / folder.name / path.name)
        for folder in folders
        for path in sorted(folder.iterdir())
        if path.suffix in (".xml", ".md", ".png")
    ]
    for source, copy in files:
        folder = copy.parent
        if os.path.lexists(folder) and not folder.is_dir():
            raise ParameterError("DIR", str(target), f"a folder where {folder.name} is a folder")
        if os.path.lexists(copy) and not _same(source, copy):
            raise ParameterError("DIR", str(target), f"a folder without another {copy.name}")
    for source, copy in files:
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, copy)
        print(copy)
    return 0


def _same(source: Path, copy: Path) -> bool:
    """Whether `copy` is a regular file with the bytes of `source`."""
    return copy.is_file() and filecmp.cmp(source, copy, shallow=False)
