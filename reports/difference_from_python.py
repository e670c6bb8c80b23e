"""The comparison of recorded motions from Python, and an assertion for a user's tests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError, positive
from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.user_models import certifiable_model, quiet, user_models
from plumbob.engines.difference.difference import ComparedMotions, compared_motions
from plumbob.engines.difference.recording import PRECISIONS, Recording, recording_of
from plumbob.engines.difference.recording_file import read_recording
from plumbob.engines.own_motion import OwnModel, Start
from plumbob.reports.judge.differences import EXPLAINED, difference_verdict
from plumbob.reports.view.difference import difference_lines, difference_record

DIFFERENCE_SECONDS = 60.0  # [s] default processor time of a comparison
RecordedMotion = str | Path | Mapping[str, Any]
"""A recorded motion: a file, or arrays by name: time, qpos, qvel, act, ctrl, qacc_warmstart."""


class DifferenceResult(ComparedMotions):
    """The answer of `plumbob.difference`.

    `verdict` is a word of `plumbob.reports.judge.differences`; `explained` says whether rounding
    and the solver explain what differs. `steps` holds for each recording the steps that are not the
    model's (`findings`), `difference` the growth of the difference beside the band."""

    @property
    def verdict(self) -> str:
        """The verdict on the recordings."""
        return difference_verdict(self)

    @property
    def explained(self) -> bool:
        """Whether rounding and the solver explain what differs."""
        return self.verdict in EXPLAINED

    def __repr__(self) -> str:
        return f"<difference: {difference_lines(self)[0]}>"

    def text(self) -> str:
        """Returns the answer as `plumbob difference` prints it."""
        return "\n".join(difference_lines(self))

    def to_dict(self) -> dict[str, Any]:
        """Returns the answer as `plumbob difference --json` prints it."""
        return difference_record(self)


@quiet()
def difference(
    a: RecordedMotion,
    b: RecordedMotion | None = None,
    model: Any = None,
    controls: Array | None = None,
    *,
    precision: str | None = None,
    keyframe: int | str | None = None,
    budget: float = DIFFERENCE_SECONDS,
    progress: Callable[[str], None] = lambda what: None,
) -> DifferenceResult:
    """Compares two recorded motions of a `model`, or one with the model's own steps: does rounding
    explain the difference, and which steps are not the model's?

    `a` and `b` are files (.npz, .csv, .json) or arrays by name: `time` [s], `qpos`, `qvel`, `act`,
    `ctrl`, and `qacc_warmstart` if it was recorded, a row for each sample. The controls of a row
    are held from its sample on; `controls` replace those of both. `model` is a path to a model
    file, a `mujoco.MjModel`, an `MjSpec` or an `MjData`; mocap poses are those of its state, or of
    a `keyframe`. `precision` is "float64" or "float32"; by default it is what the numbers show. The
    comparison takes about `budget` [s] of processor time. Raises ParameterError.

    >>> import mujoco, numpy
    >>> rod = '''<mujoco><worldbody><body><joint axis="0 1 0"/>
    ...   <geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>'''
    >>> model = mujoco.MjModel.from_xml_string(rod)
    >>> data = mujoco.MjData(model)
    >>> rows = []
    >>> for _ in range(20):
    ...     rows.append((data.time, *data.qpos, *data.qvel))
    ...     mujoco.mj_step(model, data)
    >>> time, qpos, qvel = numpy.array(rows).T
    >>> difference({"time": time, "qpos": qpos, "qvel": qvel}, model=model).verdict
    'explained'
    """
    positive("budget", budget)
    if precision is not None and precision not in PRECISIONS:
        raise ParameterError("precision", precision, f"one of {', '.join(PRECISIONS)}")
    own = recorded_model(model, Start(keyframe))
    given = [("a", a)] if b is None else [("a", a), ("b", b)]
    recordings = tuple(
        _recording(name, motion, own, controls, precision) for name, motion in given
    )
    compared = compared_motions(own, recordings, Allowance(budget, progress=progress))
    return DifferenceResult(**vars(compared))


def recorded_model(model: Any, start: Start) -> OwnModel:
    """Returns the model of recorded motions. Raises ParameterError."""
    if model is None:
        raise ParameterError("model", None, "the model of the recorded motions")
    with certifiable_model(model, "one whose steps depend on its state and controls alone"):
        return user_models().model(model, start)


def _recording(
    name: str,
    motion: RecordedMotion,
    model: OwnModel,
    controls: Array | None,
    precision: str | None,
) -> Recording:
    """Returns a recorded motion, from a file or from arrays. Raises ParameterError."""
    if isinstance(motion, (str, Path)):
        arrays = read_recording(name, Path(motion))
        name = Path(motion).name
    elif isinstance(motion, Mapping):
        arrays = motion
    else:
        raise ParameterError(name, type(motion).__name__, "a file, or arrays by name")
    return recording_of(arrays, name, model, controls, precision)


def assert_same_motion(
    a: RecordedMotion,
    b: RecordedMotion | None,
    model: Any,
    precision: str | None = None,
    controls: Array | None = None,
    *,
    budget: float = DIFFERENCE_SECONDS,
) -> None:
    """Raises AssertionError if rounding in a `precision` ("float64" or "float32") and the solver do
    not explain what differs between two recorded motions, or between one and the model if `b` is
    None. The message has the step and the term. Arguments are those of `difference`."""
    __tracebackhide__ = True
    result = difference(a, b, model, controls, precision=precision, budget=budget)
    if not result.explained:
        raise AssertionError(result.text())
