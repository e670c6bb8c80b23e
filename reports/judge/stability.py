"""Verdicts on largest steps: is the largest step at which a method holds the predicted one?"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from plumbob.engines.registry import limits_of
from plumbob.engines.study.loop_limits import LoopSearch
from plumbob.engines.study.measurement import REFERENCE_STEP
from plumbob.engines.study.results import Study
from plumbob.engines.study.stability import MeasuredLimit, SceneLimits, StabilitySearch

# Chosen relative distances of the prediction from the nearer end of a bracket that is 1 % wide. At
# an equilibrium eigenvalues set the limit. Elsewhere the limit is the step at which chaos begins,
# and depends on the start too.
AT_EQUILIBRIUM, AWAY_FROM_EQUILIBRIUM = 0.02, 0.1
# The same for a loop: the map of the scheme's steps is the engine's but for rounding.
IN_LOOP = 0.01
# largest relative difference between a measured ratio and the ratio that a known limit states
KNOWN_RATIO = 0.02
LimitVerdict = Literal["predicted", "off-prediction", "measured"]


@dataclass(frozen=True)
class JudgedLimit:
    """A limit of the step with its verdict: `measured` if no theory predicts it for this motion."""

    scene: str
    method: str
    limit: MeasuredLimit | None  # None: the method has no limit on this scene
    verdict: LimitVerdict
    why: str  # the reason why there is no limit, or the failure beyond the limit
    surprise: str = ""  # why the verdict is not as expected
    known: str = ""  # the reason of a known limit
    step: float | None = None  # [s] of the limits of a loop; None: the limit is one of the step
    about = "largest step"

    def record(self) -> dict[str, Any]:
        """The record that `plumbob stability --json` prints, in seconds; a gain is a factor."""
        found = self.limit
        return {
            "scene": self.scene,
            "method": self.method,
            "kind": found and found.kind,
            "predicted": found and found.predicted,
            "holds": found and found.holds,
            "fails": found and found.fails,
            "why": self.why,
            "predicted_why": found.reason if found else "",
            "verdict": self.verdict,
            "expected": not self.surprise,
            "known_limit": self.known,
            "continuous": found and found.continuous,
            "step": self.step,
        }


def judged_limits(
    search: StabilitySearch | LoopSearch, measured: SceneLimits
) -> Iterator[JudgedLimit]:
    """Yields the judged limits of a scene with a method. If there is no limit, it yields one record
    without a limit, with the reason."""
    if not measured.limits:
        yield JudgedLimit(search.scene, search.method, None, "measured", measured.why)
    for limit in measured.limits:
        yield _judged_limit(search, measured, limit)


def _judged_limit(
    search: StabilitySearch | LoopSearch, measured: SceneLimits, limit: MeasuredLimit
) -> JudgedLimit:
    """Returns one of the measured limits with its verdict, compared with the known limits of the
    method."""
    ratio = None
    if not _belongs_to_changed_motion(limit, measured):
        ratio = limit_ratio(limit)
    in_loop = isinstance(search, LoopSearch)
    allowed = AT_EQUILIBRIUM if measured.equilibrium else AWAY_FROM_EQUILIBRIUM
    allowed = IN_LOOP if in_loop else allowed
    verdict: LimitVerdict = "predicted"
    if ratio is None:
        verdict = "measured"
    elif abs(ratio - 1.0) > allowed:
        verdict = "off-prediction"
    known = limits_of(search.method).step_limit(search.scene, search.method, limit.kind)
    surprise = ""
    if known is not None:
        surprise = _known_ratio_mismatch(ratio, known.ratio)
    elif verdict == "off-prediction":
        surprise = f"{ratio:.3g} of the predicted {limit.kind if in_loop else 'step'}"
    return JudgedLimit(
        scene=search.scene,
        method=search.method,
        limit=limit,
        verdict=verdict,
        why=limit.why,
        surprise=surprise,
        known="" if known is None else known.reason,
        step=(search.step or REFERENCE_STEP) if isinstance(search, LoopSearch) else None,
    )


def _known_ratio_mismatch(ratio: float | None, known: float) -> str:
    """Message if the ratio of a limit to its prediction differs from the known ratio, or if there
    is no prediction; empty if it does not."""
    if ratio is None:
        now = "without a prediction"
    elif abs(ratio - known) > KNOWN_RATIO * known:
        now = f"{ratio:.3g} of it"
    else:
        return ""
    return f"known as {known:g} of the predicted step, now {now}"


def _belongs_to_changed_motion(limit: MeasuredLimit, measured: SceneLimits) -> bool:
    """Whether a limit belongs to another motion than the exact one. This happens away from an
    equilibrium if the motion changes its kind at clearly smaller steps. Theory does not predict how
    long the changed motion lasts."""
    if measured.equilibrium or limit.kind != "unstable":
        return False
    clearly_smaller = (1.0 - AWAY_FROM_EQUILIBRIUM) * (limit.holds or 0.0)
    changes = [other.fails for other in measured.limits if other.kind == "changes-kind"]
    return any(fails is not None and fails < clearly_smaller for fails in changes)


def limit_ratio(limit: MeasuredLimit) -> float | None:
    """Returns the ratio of the measured limit to the predicted one. The measured limit is the end
    of the bracket that is nearer to the prediction; the ratio is 1 if the prediction is inside the
    bracket. None without a prediction."""
    predicted = limit.predicted
    if predicted is None:
        return None
    if limit.fails is not None and limit.fails < predicted:
        return limit.fails / predicted
    if limit.holds is None or limit.holds <= predicted:
        return 1.0
    return math.inf if limit.fails is None else limit.holds / predicted


def study_limits(study: Study) -> Iterator[JudgedLimit]:
    """Yields the judged limits that a study holds. A search whose engine is missing, or whose
    process was lost, gives one record with that reason."""
    lost = SceneLimits((), why="its engine is missing, or its process was lost")
    for request in study.extras:
        if isinstance(request, StabilitySearch) and not request.by_runs:
            continue
        if isinstance(request, StabilitySearch | LoopSearch):
            yield from judged_limits(request, study.answer(request) or lost)
