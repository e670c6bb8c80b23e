"""Records of a study that its pages show beside measurements: verdicts, and numbers of exact
motions, of theory and of advice, worked out when the study is made and stored with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.abilities import Settings
from plumbob.engines.study.codec import restored
from plumbob.engines.study.results import Study
from plumbob.reports.advice.recommend import Recommendation
from plumbob.reports.advice.user_settings import UserResult
from plumbob.reports.judge.expectations import Standing
from plumbob.reports.judge.tolerance import Tolerance
from plumbob.reports.judge.verdict import Verdict

SCENE, STUDY = "page of a scene", "pages"  # places of analyses


@dataclass(frozen=True)
class Layer:
    """One body of a replay: how it is drawn, its name, what the legend adds, its largest error over
    the replay, and the one at its end."""

    slot: str  # how it is drawn: exact, first or second
    name: str
    words: str
    largest: str = ""
    end: str = ""


@dataclass(frozen=True)
class Replay:
    """A scene's replay as the page's template takes it."""

    scene: str
    kind: str  # of picture
    seconds: float
    whole: float  # duration of the scene [s]
    layers: tuple[Layer, ...]
    lacking: tuple[str, ...]  # runs that did not reach their end
    factors: tuple[int, ...]  # that errors are drawn by
    magnified: int  # how many times as large the page of an audit draws errors at first
    data: str  # JSON for the script, which no HTML parser takes for a tag


@dataclass(frozen=True)
class Budget:
    """The tolerance of one observable in one run, with its error; `exceeded` says why it is not
    within."""

    observable: str
    error: float
    tolerance: Tolerance
    exceeded: str = ""


@dataclass(frozen=True)
class RunVerdict:
    """The verdict on one run, and the bound on its error of the leading observable."""

    verdict: Verdict
    reason: str
    bound: float | None = None


@dataclass(frozen=True)
class PairVerdict:
    """The verdict on a method on a scene, and on its runs, coarse to fine."""

    verdict: Verdict
    reason: str
    standing: Standing
    expected: Verdict
    declared: str  # the reason of what is expected
    runs: tuple[RunVerdict, ...] = ()
    unjudged: Mapping[str, str] = field(default_factory=dict)  # {observable: why}
    surprise: str = ""  # why the verdict is not the expected one
    budget_step: float = 0.0  # of the run whose tolerance is shown: [s], or relative tolerance
    budgets: tuple[Budget, ...] = ()

    @property
    def mark(self) -> str:
        """The mark beside a verdict: `known`, `unexpected`, or nothing."""
        return {"unexpected": "unexpected", "known limit": "known"}.get(self.standing, "")


@dataclass(frozen=True)
class Motion:
    """Samples of a scene's exact motion: the leading observable, and the second one, if any."""

    times: tuple[float, ...]  # [s]
    channels: tuple[tuple[float, ...], ...]
    periods: int = 0  # that are shown; 0: all of the scene


@dataclass(frozen=True)
class ExactRecord:
    """The exact motion of a scene, and what is computed from it."""

    motion: Motion
    facts: Mapping[str, Any]  # exactly known: numbers and texts
    replay: Replay | None  # of a system with a picture


@dataclass(frozen=True)
class SceneRecord:
    """The record of a scene."""

    verdicts: Mapping[str, PairVerdict]  # by method
    recommendations: tuple[Recommendation, ...]  # one an error; none where nothing was timed
    exact: ExactRecord | None
    """None of a system of another package where no run was held to it: it may be a defect."""


@dataclass(frozen=True)
class SystemRecord:
    """A system as its page names it."""

    name: str
    title: str
    default: str  # the case that stands for it
    picture: str  # a file's name, or ""
    added: bool  # by another package


@dataclass(frozen=True)
class StudyRecord:
    """The record of a study, apart from its scenes."""

    systems: tuple[SystemRecord, ...]
    pictures: Mapping[str, str]  # PNG in base64 by the file's name
    settings: Mapping[str, Settings]  # to copy, by method
    user: tuple[UserResult, ...]


@dataclass(frozen=True)
class Records:
    """All records of a study."""

    study: StudyRecord
    scenes: Mapping[str, SceneRecord]


def records_of(study: Study) -> Records:
    """The records that are stored with a study; raises ParameterError where they are not there, or
    are those of another version."""
    try:
        (about,) = (a.numbers for a in study.analyses if a.place == STUDY)
        pages = {a.scene: a.numbers for a in study.analyses if a.place == SCENE}
        scenes = {s.name: restored(pages[s.name], SceneRecord) for s in study.scenes}
        judged = {(name, method) for name, of in scenes.items() for method in of.verdicts}
        if judged != {(c.scene, c.method) for c in study.convergence}:
            raise ValueError("other pairs are judged than were measured")
        return Records(restored(about, StudyRecord), scenes)
    except (KeyError, ValueError):
        raise ParameterError(
            "study",
            study.provenance.date,
            "stored with the numbers of its pages, as this version of `plumbob validate` stores it",
        ) from None
