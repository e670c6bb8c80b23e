"""plumbob view: show a scene, driven as it is measured, or a model file in MuJoCo's viewer."""

from __future__ import annotations

import argparse
import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import Unsupported
from plumbob.engines.own_motion import NotCertifiable, Start
from plumbob.reports.commands.arguments import values
from plumbob.reports.commands.arguments.console import note
from plumbob.reports.commands.shared.model_file import is_model_file, model_and_script

if TYPE_CHECKING:
    from plumbob.analytic.reference import Array
    from plumbob.engines.abilities import MotionView, Views

MISSING_PART = 3
FILE_SECONDS = 3.0  # [s] shown time of a model file, unless the user gives another
MAX_VIEW_SECONDS = 10.0  # [s] longest shown time of a scene, unless the user gives another
MAX_VIEW_STEPS = 2_000_000  # largest number of steps of a picture, which take about a minute
FRAME_SECONDS = 0.05  # [s] time between two pictures of a GIF, whose unit is 10 ms
MOST_FRAMES = 100  # five seconds; a software renderer takes up to a second for each
LEAST_PLAYED = 2.0  # [s] a GIF plays at least as long
SLOWNESS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # factors by which a motion is slowed
PICTURE_WIDTH, PICTURE_HEIGHT = 480, 360  # [pixels]
WITHOUT_PILLOW = "pictures are written by pillow, which is not installed: pip install pillow"
# Options that a scene does not take.
START_OPTIONS = ("keyframe", "qpos", "qvel", "ctrl", "ctrl_period")


def command(chosen: argparse.Namespace) -> int:
    """Opens the viewer, or writes the pictures that the user asks for. Returns 3, after a line that
    says what is missing, if there is no display, no offscreen renderer or no pillow."""
    from plumbob.reports.advice.fixed_file import check_new_file

    build = _file_view if is_model_file(chosen, ("changes",), START_OPTIONS) else _scene_view
    for name in ("gif", "png"):
        if getattr(chosen, name):
            check_new_file(name, Path(getattr(chosen, name)), f".{name}")
    if chosen.at is not None and not chosen.png:
        raise ParameterError("at", chosen.at, "given with --png")
    pictures = bool(chosen.gif or chosen.png)
    if pictures and not _has_pillow():
        note(WITHOUT_PILLOW)
        return MISSING_PART
    try:
        if not pictures:
            build(chosen)[0].show()
            return 0
        _views().prepare()
        if chosen.png:
            _write_png(chosen, *build(chosen))
        if chosen.gif:
            _write_gif(chosen, *build(chosen))
    except Unsupported as why:
        note(str(why))
        return MISSING_PART
    return 0


def _has_pillow() -> bool:
    """Returns whether the package that writes pictures is installed."""
    from importlib.util import find_spec

    return find_spec("PIL") is not None


def _views() -> Views:
    """Returns MuJoCo's ability to show models."""
    from plumbob.engines.abilities import Views
    from plumbob.engines.registry import find_engine

    views = find_engine("mujoco").ability(Views)
    assert views is not None
    return views


def _scene_view(chosen: argparse.Namespace) -> tuple[MotionView, float]:
    """Returns a scene to look at, and its shown time [s]. Raises Unsupported and ParameterError."""
    from plumbob.engines.audit.scene_reference import model_method
    from plumbob.engines.study.measurement import REFERENCE_STEP
    from plumbob.models.registry import case_of
    from plumbob.models.registry import scene as find_scene

    with values.representable(chosen.changes, chosen):
        case = case_of(find_scene(chosen.scene, chosen.changes))
        duration = case.scene.duration
        step = duration / max(1, round(duration / REFERENCE_STEP))
        view = _views().scene(case, model_method(case), step)
    return view, chosen.duration or min(duration, MAX_VIEW_SECONDS)


def _file_view(chosen: argparse.Namespace) -> tuple[MotionView, float]:
    """Returns a model file to look at, and its shown time [s]. Raises Unsupported and
    ParameterError."""
    shown = chosen.duration or FILE_SECONDS
    controls: Array | None = None
    period = chosen.ctrl_period or shown
    if chosen.ctrl != "rest":
        chosen.duration, chosen.budget = shown, MAX_VIEW_SECONDS
        _, script = model_and_script(chosen)
        controls, period = script.controls, script.period
    start = Start(chosen.keyframe, chosen.qpos, chosen.qvel)
    try:
        return _views().file(Path(chosen.scene), start, controls, period), shown
    except NotCertifiable as why:
        raise ParameterError(
            "scene", chosen.scene, f"a model that can be shown; {why}"
        ) from None


def _rendered(view: MotionView, times: Sequence[float], name: str) -> list[Any]:
    """Returns pictures of a view at rising times [s], as pillow's images. Raises ParameterError for
    the option `name`, which gives the last time, if they take too many steps."""
    from PIL import Image

    if times[-1] > MAX_VIEW_STEPS * view.step:
        expected = f"at most {MAX_VIEW_STEPS * view.step:g} s at the step of {view.step:g} s"
        raise ParameterError(name, times[-1], expected)
    marks = [round(time / view.step) for time in times]
    return [
        Image.fromarray(frame) for frame in view.frames(marks, PICTURE_WIDTH, PICTURE_HEIGHT)
    ]


def _write_png(chosen: argparse.Namespace, view: MotionView, shown: float) -> None:
    """Writes the picture --png. Raises ParameterError."""
    time = chosen.at or 0.0
    (image,) = _rendered(view, [time], "at")
    _save(image, Path(chosen.png), f"{time:g} s", format="PNG")


def _write_gif(chosen: argparse.Namespace, view: MotionView, shown: float) -> None:
    """Writes the moving picture --gif of the shown time [s]. Raises ParameterError."""
    slowness = next((k for k in SLOWNESS if k * shown >= LEAST_PLAYED), SLOWNESS[-1])
    count = max(2, round(slowness * shown / FRAME_SECONDS))
    faster = -(-count // MOST_FRAMES)
    times = [k * shown / count for k in range(0, count + 1, faster)]
    first, *others = _rendered(view, times, "duration")
    _save(
        first,
        Path(chosen.gif),
        f"{shown:g} s in {len(times)} pictures, {faster / slowness:g} × real speed",
        format="GIF",
        save_all=True,
        append_images=others,
        duration=round(1000 * FRAME_SECONDS),  # [ms]
        loop=0,
    )


def _save(image: Any, target: Path, about: str, **settings: Any) -> None:
    """Writes a picture to a new file, whole or not at all, and prints its name and what it
    shows."""
    from plumbob.reports.view.page import write_file

    content = io.BytesIO()
    image.save(content, **settings)
    write_file(content.getvalue(), target.parent, target.name)
    print(f"{target}: {about}")
