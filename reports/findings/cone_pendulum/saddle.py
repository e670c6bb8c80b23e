"""Hard cases of the cone pendulum: how errors grow next to a saddle, and over a million steps."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.analytic.systems.cone_pendulum import ConePendulum
from plumbob.engines.study.results import Study
from plumbob.models.registry import system_of
from plumbob.models.scene import Scene
from plumbob.reports.findings.cone_pendulum import energy
from plumbob.reports.findings.saddle_growth import Saddle, saddle_growth
from plumbob.reports.view.content import Figure, Table


def hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    """Growth of the errors next to a separatrix; energy over a million steps."""
    if scene.name.endswith("/million-steps"):
        return energy.hard(scene.name)
    problem: ConePendulum = system_of(scene).problem(scene.parameters)
    saddles = [e for e in problem.equilibria if e.kind == "saddle"]
    if not saddles:
        return ()
    highest = max(saddles, key=lambda e: e.potential)
    return saddle_growth(study, scene, problem.motion, Saddle(highest.theta, highest.rate))
