"""Records that the pages of a study show beside its measurements: verdicts, exact motions, theory
and recommendations. They are computed when the study is made and stored with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import Settings
from plumbob.engines.study.codec import restored
from plumbob.engines.study.results import Study
from plumbob.reports.advice.recommend import Recommendation
from plumbob.reports.advice.user_settings import UserResult
from plumbob.reports.judge.expectations import VerdictStanding
from plumbob.reports.judge.tolerance import Tolerance
from plumbob.reports.judge.verdict import Verdict

T = TypeVar("T")
# direction from which a replay is seen: across the plane of the motion, from above, or obliquely
ReplayView = Literal["plane", "above", "oblique"]
# where analyses appear: on the page of a scene; on the pages of the study
SCENE, PAGES_OF_STUDY = (
    "page of a scene",
    "pages",
)
# section and page with the findings on engines that hold for every system
ENGINES_SECTION = "engines"
# relative errors for which methods are recommended, each with its text on the page
ERROR_LEVELS = ((0.1, "10 %"), (1e-2, "1 %"), (1e-3, "0.1 %"), (1e-4, "1e-4"), (1e-6, "1e-6"))
SHOWN_SETTINGS = (  # methods whose settings a reader may copy, each with the title of its settings
    ("mujoco/euler+coulomb", "A robot with contacts in MuJoCo"),
    ("mujoco/rk4", "A robot without contacts in MuJoCo"),
    ("pymunk/feet", "A body that slides in pymunk, seen from above"),
)
# scenes whose largest stable steps the first screen shows; the quick profile predicts them
LIMITED_SCENES = (
    "simple-pendulum/free-large",
    "cone-pendulum/rotating-base",
    "cone-pendulum/fast-platform",
    "linear-pendulum/overdamped",
    "free-body/flip",
)


@dataclass(frozen=True)
class Layer:
    """One moving body of a replay: its drawing style, its name and words in the legend, its largest
    error over the replay and its error at the end."""

    slot: str  # drawing style: exact, first or second
    name: str
    words: str
    largest: str = ""
    end: str = ""


@dataclass(frozen=True)
class Replay:
    """The values of a scene's replay in the page's template."""

    scene: str
    kind: str  # direction of view; an older study may have another kind, which is not drawn
    seconds: float
    whole: float  # duration of the scene [s]
    layers: tuple[Layer, ...]
    lacking: tuple[str, ...]  # runs that did not reach their end
    factors: tuple[int, ...]  # magnifications of errors that a reader may choose
    magnified: int  # magnification of errors that the page of an audit starts with
    data: str  # JSON for the script, without any text that an HTML parser takes for a tag
    thumbnail: str = ""  # such JSON of the exact motion alone, with few samples


@dataclass(frozen=True)
class Budget:
    """The error and the tolerance of one observable in one run; `exceeded` is the reason if the
    error exceeds the tolerance, else empty."""

    observable: str
    error: float
    tolerance: Tolerance
    exceeded: str = ""


@dataclass(frozen=True)
class RunVerdict:
    """The verdict on one run, its reason, and the bound on the error of the leading observable."""

    verdict: Verdict
    reason: str
    bound: float | None = None


@dataclass(frozen=True)
class PairVerdict:
    """The verdict on a method on a scene, with the verdicts on its runs, coarse to fine."""

    verdict: Verdict
    reason: str
    standing: VerdictStanding
    expected: Verdict
    declared: str  # the declared reason of the expected verdict
    runs: tuple[RunVerdict, ...] = ()
    unjudged: Mapping[str, str] = field(default_factory=dict)  # {observable: why}
    surprise: str = ""  # why the verdict is not the expected one
    budget_step: float = 0.0  # step [s], or tolerance, of the run whose budgets are shown
    budgets: tuple[Budget, ...] = ()

    @property
    def mark(self) -> str:
        """The mark beside the verdict: `known` for a known limit, `unexpected`, or empty."""
        return {"unexpected": "unexpected", "known limit": "known"}.get(self.standing, "")


@dataclass(frozen=True)
class MotionSamples:
    """Samples of a scene's exact motion: the leading observable and, if there is one, the
    second."""

    times: tuple[float, ...]  # [s]
    channels: tuple[tuple[float, ...], ...]  # values of one observable per channel
    periods: int = 0  # number of periods shown; 0: the whole scene


@dataclass(frozen=True)
class ExactRecord:
    """The exact motion of a scene, with the facts and the replay that are computed from it."""

    motion: MotionSamples
    facts: Mapping[str, Any]  # exactly known numbers and texts, by name
    replay: Replay | None  # None for a system without a picture


@dataclass(frozen=True)
class SceneRecord:
    """The verdicts, recommendations and exact motion of one scene."""

    verdicts: Mapping[str, PairVerdict]  # by method
    # one per wanted error; empty if nothing was timed
    recommendations: tuple[Recommendation, ...]
    exact: ExactRecord | None
    """None if another package supplies the system and no run was compared with the exact motion:
    the motion may be defective."""


@dataclass(frozen=True)
class SystemRecord:
    """The names and the picture of a system on its page."""

    name: str
    title: str
    default: str  # case that stands for the system
    picture: str  # file name of the picture, or ""
    added: bool  # whether another package supplies the system
    phenomenon: int = 0  # row in the table of canonical phenomena, from 1; 0: in no row


@dataclass(frozen=True)
class StudyRecord:
    """The records of a study that belong to no single scene."""

    systems: tuple[SystemRecord, ...]  # in the order of the pages
    pictures: Mapping[str, str]  # PNG in base64, by file name
    settings: Mapping[str, Settings]  # settings to copy, by method
    user: tuple[UserResult, ...]
    # MJCF of the settings that the index advises, by `advised_name`
    advised: Mapping[str, str] = field(default_factory=dict)


def advised_name(method: str, step: float) -> str:
    """Returns the name by which the settings of a method at a step [s] are stored."""
    return f"{method} at {step:g}"


@dataclass(frozen=True)
class Records:
    """All records of a study."""

    study: StudyRecord
    scenes: Mapping[str, SceneRecord]


def records_of(study: Study) -> Records:
    """Returns the records that are stored with a study; raises ParameterError if they are missing
    or were stored by another version."""
    try:
        (of_study,) = (a.numbers for a in study.analyses if a.place == PAGES_OF_STUDY)
        by_scene = {a.scene: a.numbers for a in study.analyses if a.place == SCENE}
        scenes = {s.name: _record(by_scene[s.name], SceneRecord) for s in study.scenes}
        judged = {(name, method) for name in scenes for method in scenes[name].verdicts}
        measured = {(series.scene, series.method) for series in study.convergence}
        if judged != measured:
            raise ValueError("other pairs are judged than were measured")
        return Records(_record(of_study, StudyRecord), scenes)
    except (KeyError, ValueError):
        raise ParameterError(
            "study",
            study.provenance.date,
            "stored with the numbers of its pages, as this version of `plumbob validate` stores it",
        ) from None


def _record(numbers: Any, kind: type[T]) -> T:
    """Returns the record of this kind: `numbers` if the study was made in this process, else the
    record that their stored values describe. Raises ValueError if they describe none."""
    return numbers if isinstance(numbers, kind) else restored(numbers, kind)
