"""Verdicts on largest steps: is the largest step at which a method holds the predicted one?"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from plumbob.engines.registry import limits_of
from plumbob.engines.study.results import Study
from plumbob.engines.study.stability import MeasuredLimit, Stability, StabilitySearch

# Chosen relative distances of the prediction from the nearer end of a bracket that is 1 % wide. At
# an equilibrium eigenvalues set the limit. Elsewhere the limit is the step at which chaos begins,
# and depends on the start too.
AT_EQUILIBRIUM, ELSEWHERE = 0.02, 0.1
KNOWN = 0.02  # largest relative difference from the ratio of a known limit
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
    about = "largest step"

    def record(self) -> dict[str, Any]:
        """The record that `plumbob stability --json` prints, in seconds."""
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
        }


def judged_limits(search: StabilitySearch, found: Stability) -> Iterator[JudgedLimit]:
    """Yields the judged limits of a scene with a method. If there is no limit, it yields one record
    without a limit, with the reason."""
    names = search.scene, search.method
    if not found.limits:
        yield JudgedLimit(*names, None, "measured", found.why)
    for limit in found.limits:
        allowed = AT_EQUILIBRIUM if found.equilibrium else ELSEWHERE
        ratio = None if _of_another(limit, found) else off_by(limit)
        off = ratio is not None and abs(ratio - 1.0) > allowed
        verdict: LimitVerdict = "off-prediction" if off else "predicted"
        if ratio is None:
            verdict = "measured"
        known = limits_of(search.method).step_limit(*names, limit.kind)
        expected = 1.0 if known is None else known.ratio
        surprise = ""
        if off and known is None:
            surprise = f"{ratio:.3g} of the step that is predicted"
        elif known is not None and (ratio is None or abs(ratio - expected) > KNOWN * expected):
            measured = "without a prediction" if ratio is None else f"{ratio:.3g} of it"
            surprise = f"known as {expected:g} of the step that is predicted, now {measured}"
        reason = "" if known is None else known.reason
        yield JudgedLimit(*names, limit, verdict, limit.why, surprise, reason)


def _of_another(limit: MeasuredLimit, found: Stability) -> bool:
    """Whether a limit belongs to another motion than the exact one. This happens away from an
    equilibrium if the motion changes its kind at clearly smaller steps. Theory does not predict how
    long the changed motion lasts."""
    if found.equilibrium or limit.kind != "unstable":
        return False
    changed = (other.fails for other in found.limits if other.kind == "changes-kind")
    return any(f is not None and f < (1.0 - ELSEWHERE) * (limit.holds or 0.0) for f in changed)


def off_by(limit: MeasuredLimit) -> float | None:
    """Returns the ratio of the measured limit to the predicted one. The measured limit is the end
    of the bracket that is nearer to the prediction; the ratio is 1 if the prediction is inside the
    bracket. None without a prediction."""
    if limit.predicted is None:
        return None
    if limit.fails is not None and limit.fails < limit.predicted:
        return limit.fails / limit.predicted
    if limit.holds is not None and limit.holds > limit.predicted and limit.fails is not None:
        return limit.holds / limit.predicted
    beyond = limit.fails is None and limit.holds is not None and limit.predicted < limit.holds
    return math.inf if beyond else 1.0


def study_limits(study: Study) -> Iterator[JudgedLimit]:
    """Yields the judged limits that a study holds. A search whose engine is missing, or whose
    process was lost, gives one record with that reason."""
    for request in study.extras:
        if not (isinstance(request, StabilitySearch) and request.by_runs):
            continue
        why = "its engine is missing, or its process was lost"
        yield from judged_limits(request, study.answer(request) or Stability((), why=why))
