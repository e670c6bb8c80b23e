"""Differences between releases of an engine: verdicts and errors of scenes, and the certified
motions, errors and fields of model files."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from plumbob.engines.audit.changes import audited_file, changes
from plumbob.engines.releases.measuring import Release
from plumbob.reports.judge.study_differences import study_differences

# Changes of an audited model that tell what the release reads in another way: they explain a moved
# result and are none themselves.
EXPLANATIONS = ("field ", "version of ")
Measure = Callable[[int], Release]
"""A function that measures the release with a number in the list of releases."""


@dataclass(frozen=True)
class ReleaseChange:
    """A difference between two releases of an engine, on one scene or model file."""

    before: str  # the older release
    version: str  # the newer release
    subject: str  # names of a scene and a method, or the path of a model file
    what: str
    old: str
    new: str
    # Growth of an error relative to the old error; infinite if something is lost; None if the
    # difference is no error's
    growth: float | None = None

    @property
    def explains(self) -> bool:
        """Whether the change explains moved results, and is no moved result itself."""
        return self.what.startswith(EXPLANATIONS)

    def is_beyond(self, limit: float) -> bool:
        """Whether a result moved by more than a limit, as a fraction of the old error; a verdict or
        a certified motion that changed is beyond each limit."""
        if self.explains:
            return False
        return self.growth is None or abs(self.growth) > limit


def release_changes(old: Release, new: Release) -> list[ReleaseChange]:
    """Returns the differences between two releases that were measured; those that moved results
    come first, and the largest of these."""
    found = [*_scene_changes(old, new), *_model_changes(old, new)]
    found.sort(key=lambda change: (change.explains, -_size(change)))
    return [replace(change, before=old.version, version=new.version) for change in found]


def _size(change: ReleaseChange) -> float:
    """Returns the magnitude of a change's growth; infinite if the change has none."""
    return math.inf if change.growth is None else abs(change.growth)


def _scene_changes(old: Release, new: Release) -> Iterator[ReleaseChange]:
    """Gives the changes of verdicts, and for each scene and method the largest change of an
    error."""
    if old.study is None or new.study is None:
        return
    rows = study_differences(old.study, new.study)
    largest: dict[str, ReleaseChange] = {}
    for kind in ("verdicts", "presence", "errors"):
        for row in rows[kind]:
            subject = f"{row['scene']} {row['method']}"
            change = ReleaseChange(
                before="",
                version="",
                subject=subject,
                what=row["what"],
                old=str(row["old"]),
                new=str(row["new"]),
                growth=row["growth"],
            )
            if kind == "verdicts":
                yield change
            elif subject not in largest or _size(change) > _size(largest[subject]):
                largest[subject] = change
    yield from largest.values()


def _model_changes(old: Release, new: Release) -> Iterator[ReleaseChange]:
    """Gives the changes of the audits of model files."""
    older = {audited_file(audit): audit for audit in old.audits}
    for now in new.audits:
        subject = audited_file(now)
        if subject not in older:
            continue
        before = older[subject]
        refusals = [str(audit.get("why", "")) for audit in (before, now)]
        lost = ["fields" not in audit for audit in (before, now)]
        if any(lost):
            if lost[0] != lost[1]:
                was, now_is = (why or "certified" for why in refusals)
                yield ReleaseChange("", "", subject, "audit", was, now_is)
            continue
        for change in changes(before, now):
            yield ReleaseChange(
                "", "", subject, change.what, change.old, change.new, change.growth
            )


@dataclass(frozen=True)
class FirstChange:
    """The answer to the question which release changed a result."""

    # "none": first and last release agree, and none of those tried differs; "moved": the first
    # release that differs is known; "returned": a release between two that agree differs;
    # "several": the releases in between agree with neither end
    outcome: str
    before: str = ""  # the newest release known to agree with the first
    version: str = ""  # the oldest release known to differ
    tried: tuple[str, ...] = ()  # releases that were measured, in this order


def first_change(versions: Sequence[str], measure: Measure, limit: float) -> FirstChange:
    """Returns the first of the `versions`, old to new, whose results differ from the oldest
    version's by more than `limit`, a fraction of an error. The number of releases that are measured
    is at most 2 more than the logarithm of their number to base 2, rounded up; if oldest and newest
    agree and a release in between differs, at most twice that. If a release cannot be measured, it
    counts as differing."""
    tried: dict[int, Release] = {}

    def differs(number: int, other: int = 0) -> bool:
        """Returns whether two releases differ by more than the limit."""
        for each in (other, number):
            if each not in tried:
                tried[each] = measure(each)
        old, new = tried[other], tried[number]
        if old.why or new.why:
            return bool(old.why) != bool(new.why)
        return any(change.is_beyond(limit) for change in release_changes(old, new))

    low, high = 0, len(versions) - 1
    outcome = "moved"
    if not high or not differs(high):
        high = _differing_between(high, differs)
        if not high:
            return FirstChange("none", tried=_named(versions, tried))
        outcome = "returned"
    last = high
    while high - low > 1:
        middle = (low + high) // 2
        if not differs(middle):
            low = middle
            continue
        if outcome == "moved" and differs(last, middle):
            outcome = "several"
        high = middle
    return FirstChange(outcome, versions[low], versions[high], _named(versions, tried))


def _differing_between(last: int, differs: Callable[[int], bool]) -> int:
    """Returns the number of a release between the first and the last that differs from the first; 0
    if none of those tried does. Middles of ever smaller intervals are tried, as many as a search by
    halves would try."""
    spans = [(0, last)]
    for _ in range(math.ceil(math.log2(last + 1)) if last else 0):
        if not spans:
            break
        low, high = spans.pop(0)
        middle = (low + high) // 2
        if middle == low:
            continue
        if differs(middle):
            return middle
        spans += [(low, middle), (middle, high)]
    return 0


def _named(versions: Sequence[str], tried: dict[int, Release]) -> tuple[str, ...]:
    """Returns the names of the releases that were measured."""
    return tuple(versions[number] for number in tried)
