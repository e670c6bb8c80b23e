"""The page's section on the simple pendulum: the notebook's cases, and what its method errs by."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.models.scene import Scene
from plumbob.reports.findings.simple_pendulum import (
    energy,
    forcing,
    near_top,
    notebook,
    orders,
    references,
    tension,
)
from plumbob.reports.view.content import Figure, Finding, Section, Table


def findings(study: Study) -> Sequence[Finding]:
    """Everything that holding the notebook and the engines against each other showed."""
    found = (
        notebook.finding(study),
        orders.finding(study),
        forcing.finding(study),
        energy.finding(study),
        tension.finding(),
        references.finding(study),
        near_top.finding(),
    )
    return [one for one in found if one is not None]


def figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    """The notebook's plots, linear and non-linear, each beside the exact answer."""
    return notebook.galleries()


def hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    """Growth of errors at the top; energy over a million steps."""
    if scene.name == energy.MILLION:
        return energy.hard(study)
    if "near-top" in scene.name:
        return near_top.hard(study, scene)
    return ()


SECTION = Section(findings, figures, hard)
