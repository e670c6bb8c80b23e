"""The page's section on plans: poses reached, what engines make of them, one plan from above."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.findings.capsule_plan import open_loop, path, poses
from plumbob.reports.findings.capsule_plan.plans import SHOWN, scenes
from plumbob.reports.view.content import Figure, Finding, Section, Table


def findings(study: Study) -> Sequence[Finding]:
    """What the planner reaches, and what engines make of its plans."""
    found = (poses.finding(study), open_loop.finding(study))
    return tuple(one for one in found if one is not None)


def _figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    """One plan drawn: the shortest, or the first that the study has."""
    names = [scene.name for scene in scenes(study)]
    if not names:
        return ()
    return (path.gallery(SHOWN if SHOWN in names else names[0]),)


def _hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    return ()


SECTION = Section(findings, _figures, _hard)
