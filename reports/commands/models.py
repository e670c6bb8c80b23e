"""plumbob models: show or copy the MJCF models, or say what engines' readers drop of a file."""

from __future__ import annotations

import argparse
import os
from contextlib import nullcontext
from pathlib import Path

from plumbob import models
from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import StepsOfFiles
from plumbob.engines.method import time_step
from plumbob.engines.registry import find_engine
from plumbob.engines.study.model_reading import every_field
from plumbob.models.registry import systems
from plumbob.reports.commands.arguments import values
from plumbob.reports.judge.model_readers import file_readings

MODELS = Path(models.__file__).parent
ABOUT = (MODELS / "README.md", MODELS.parent / "LICENSE", MODELS.parent / "CITATION.cff")
CONTACTS = b"solreffriction"  # occurs in each model whose contacts depend on the time step


def command(chosen: argparse.Namespace) -> int:
    """Prints where the models are, copies them into a new folder, or says which fields of a file
    the readers of engines drop. Raises ParameterError."""
    for name, action in (("step", "export"), ("json", "check")):
        value = getattr(chosen, name)
        if value and chosen.action != action:
            raise ParameterError(name, value, f"given with `plumbob models {action}`")
    if chosen.action == "check":
        with nullcontext(Path(chosen.path)) if chosen.path else every_field() as file:
            readers = file_readings(file)
        values.show(chosen, readers, "models", readers=readers)
        return 0
    folders = sorted(
        {system.mjcf.parent for system in systems().values() if system.mjcf.is_file()}
    )
    if chosen.action != "export":
        for folder in folders:
            print(f"{folder.name}  {folder}")
        return 0
    if chosen.path is None:
        raise ParameterError("DIR", None, "given, as `plumbob models export DIR`")
    target = Path(chosen.path)
    step = chosen.step and time_step("step", chosen.step)
    files: list[tuple[bytes, Path]] = []
    for folder in folders:
        for path in sorted(folder.iterdir()):
            if path.suffix in (".xml", ".md", ".png"):
                files.append((_content(path, step), target / folder.name / path.name))
    files += [(path.read_bytes(), target / path.name) for path in ABOUT]
    if os.path.lexists(target) and not (target.is_dir() and not any(target.iterdir())):
        raise ParameterError("DIR", str(target), "an empty folder or a new one")
    for content, copy in files:
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(content)
        print(copy)
    return 0


def _content(path: Path, step: float | None) -> bytes:
    """Returns the bytes of a copy of the file `path`; the contacts of a model are set for the time
    step `step` [s]."""
    content = path.read_bytes()
    steps = find_engine("mujoco").ability(StepsOfFiles)
    if step is None or steps is None or path.suffix != ".xml" or CONTACTS not in content:
        return content
    return steps.rewrite(content.decode("utf-8"), step).encode("utf-8")
