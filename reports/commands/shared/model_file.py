"""A model file of the user in place of a scene: its arguments, its motion, and its motion as
JSON."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.models.border import must_be, regular_file
from plumbob.reports.commands.arguments import values

if TYPE_CHECKING:
    from plumbob.engines.audit.reference import Certificate
    from plumbob.engines.own_motion import OwnModel, Script

MODEL_SUFFIXES = (".xml", ".mjcf", ".urdf", ".mjb")  # endings of model files; no scene has one
FILE_OPTIONS = ("keyframe", "qpos", "qvel", "ctrl", "ctrl_period", "duration")
# [bytes] unpacked controls: the largest number of periods for 125 actuators
LARGEST_CONTROLS = 100_000_000


def is_model_file(
    chosen: argparse.Namespace,
    scene_options: Sequence[str],
    file_options: Sequence[str] = FILE_OPTIONS,
) -> bool:
    """Returns whether the scene of a command line is a model file, by the ending of its name.
    Raises ParameterError if one of `scene_options` is given with a model file, or one of
    `file_options` with a scene."""
    names_file = Path(chosen.scene).suffix.lower() in MODEL_SUFFIXES
    if names_file:
        values.refuse_options(chosen, scene_options, "left out with a model file")
    else:
        values.refuse_options(chosen, file_options, "given with a model file")
    return names_file


def model_and_script(chosen: argparse.Namespace) -> tuple[OwnModel, Script]:
    """Returns the model in the chosen file and its motion: the start, the controls and the
    duration, or a policy in the loop. Raises ParameterError."""
    from plumbob.engines.closed_loop import load_policy
    from plumbob.engines.own_motion import Start
    from plumbob.reports.audit_from_python import user_motion

    policy = getattr(chosen, "policy", None)
    return user_motion(
        Path(chosen.scene),
        Start(chosen.keyframe, chosen.qpos, chosen.qvel),
        chosen_control(chosen.ctrl),
        None if policy is None else load_policy(policy),
        duration=chosen.duration,
        period=chosen.ctrl_period,
        budget=chosen.budget,
        in_the_loop=policy is not None,
    )


def motion_record(
    chosen: argparse.Namespace, script: Script, reference: Certificate, index: int
) -> dict[str, Any]:
    """Returns the JSON data of a model file's motion, with its uncertainty [m] at the end of
    control period number `index`."""
    from plumbob.engines.audit.reference import MEASURE

    return {
        "model": chosen.scene,
        "control": control_name(chosen.ctrl),
        "control_period": script.period,
        "duration": script.duration,
        "certified_until": float(script.times[index]),
        "uncertainty": float(reference.uncertainty[index]),
        "why": reference.why,
        "error_measure": MEASURE,
    }


def chosen_control(ctrl: str) -> Array | str:
    """Returns the control that --ctrl chooses: the name of a kind of control, or the controls in a
    file. Raises ParameterError."""
    from plumbob.engines.audit.controls import KINDS

    return ctrl if ctrl in KINDS else read_controls(Path(ctrl))


def control_name(ctrl: str) -> str:
    """Returns the name of the control that --ctrl chooses: a kind, or a file without its folder."""
    from plumbob.engines.audit.controls import KINDS

    return ctrl if ctrl in KINDS else Path(ctrl).name


def read_controls(file: Path) -> Array:
    """Returns the controls in a file, a row for each control period: the numbers of a .csv file, or
    the array `ctrl` of a .npz file. Raises ParameterError."""
    from plumbob.engines.audit.controls import KINDS
    from plumbob.engines.difference.recording_file import packed_array

    expected = f"{', '.join(KINDS)}, or a .csv or .npz file of controls"
    if file.suffix not in (".csv", ".npz"):
        raise ParameterError("ctrl", str(file), expected)
    regular_file("ctrl", file, LARGEST_CONTROLS)
    with must_be(expected, "ctrl", str(file)), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numpy warns of a file without rows and of equal names
        if file.suffix == ".csv":
            return np.loadtxt(file, delimiter=",", ndmin=2)
        return packed_array(file, "ctrl", LARGEST_CONTROLS)
