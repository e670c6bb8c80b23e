"""A model file of the user's own where a command takes a scene: its motion, and how a run of it is
described."""

from __future__ import annotations

import argparse
import io
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import ZipFile

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.models.border import must_be, regular_file
from plumbob.reports.commands.arguments import values

if TYPE_CHECKING:
    from plumbob.engines.audit.reference import Certificate
    from plumbob.engines.own_motion import OwnModel, Script

MODEL_SUFFIXES = (".xml", ".mjcf", ".urdf", ".mjb")  # of model files: no scene's name ends so
FILE_OPTIONS = ("keyframe", "qpos", "qvel", "ctrl", "ctrl_period", "duration")
LARGEST_CONTROLS = 100_000_000  # [bytes], unpacked: as many periods as may be, of 125 actuators


def is_model_file(
    chosen: argparse.Namespace,
    scene_options: Sequence[str],
    file_options: Sequence[str] = FILE_OPTIONS,
) -> bool:
    """Whether the scene of a command line is a model file, by its ending. Raises ParameterError
    for options `of_scenes` alone beside a file, and for those `of_files` beside a scene."""
    names_file = Path(chosen.scene).suffix.lower() in MODEL_SUFFIXES
    if names_file:
        values.refuse_options(chosen, scene_options, "left out with a model file")
    else:
        values.refuse_options(chosen, file_options, "given with a model file")
    return names_file


def model_and_script(chosen: argparse.Namespace) -> tuple[OwnModel, Script]:
    """The model of the file that was chosen, and its motion; raises ParameterError."""
    from plumbob.engines.audit.controls import KINDS
    from plumbob.engines.own_motion import Start
    from plumbob.reports.audit_from_python import user_motion

    control = chosen.ctrl if chosen.ctrl in KINDS else read_controls(Path(chosen.ctrl))
    return user_motion(
        Path(chosen.scene),
        Start(chosen.keyframe, chosen.qpos, chosen.qvel),
        control,
        duration=chosen.duration,
        period=chosen.ctrl_period,
        budget=chosen.budget,
    )


def motion_record(
    chosen: argparse.Namespace, script: Script, reference: Certificate, index: int
) -> dict[str, Any]:
    """The motion of a file and how well it is known up to the end of a control period, as plain
    data."""
    from plumbob.engines.audit.controls import KINDS
    from plumbob.engines.audit.reference import MEASURE

    return {
        "model": chosen.scene,
        "control": chosen.ctrl if chosen.ctrl in KINDS else Path(chosen.ctrl).name,
        "control_period": script.period,
        "duration": script.duration,
        "certified_until": float(script.times[index]),
        "uncertainty": float(reference.uncertainty[index]),
        "why": reference.why,
        "error_measure": MEASURE,
    }


def read_controls(file: Path) -> Array:
    """Controls from a .csv file, a row for each period, or the array `ctrl` of a .npz file; raises
    ParameterError."""
    from plumbob.engines.audit.controls import KINDS

    expected = f"{', '.join(KINDS)}, or a .csv or .npz file of controls"
    if file.suffix not in (".csv", ".npz"):
        raise ParameterError("ctrl", str(file), expected)
    regular_file("ctrl", file, LARGEST_CONTROLS)
    with must_be(expected, "ctrl", str(file)), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # no rows, which the shape tells; names twice
        if file.suffix == ".csv":
            return np.loadtxt(file, delimiter=",", ndmin=2)
        with ZipFile(file) as arrays, arrays.open("ctrl.npy") as packed:
            content = packed.read(LARGEST_CONTROLS + 1)
        if len(content) > LARGEST_CONTROLS:
            raise ValueError(f"more than {LARGEST_CONTROLS} bytes when unpacked")
        try:
            controls = np.load(io.BytesIO(content), allow_pickle=False)
        except MemoryError:
            raise ValueError("its header states more numbers than there are") from None
        return np.asarray(controls).astype(float, casting="same_kind")
