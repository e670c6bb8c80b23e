"""The finding on fidelity: what the reduced model saves against the full one."""

from __future__ import annotations

from dataclasses import dataclass

from plumbob.engines.registry import engine_of, installed
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.results import Study
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of
from plumbob.reports.findings.capsule.cells import method as method_cell
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import LINE, off
from plumbob.reports.view.content import Finding, Table, row
from plumbob.reports.view.notation import number, short

FULL, REDUCED = "mujoco/euler+coulomb", "mujoco/euler+reduced"
PAIRS = ((FULL, REDUCED), ("mujoco/rk4+coulomb", "mujoco/rk4+reduced"))
STEP = 1e-4  # [s]
STEPS, TURNS = 300, 7  # the push, so often


@dataclass(frozen=True)
class Saved:
    """Cost of a step of the full and of the reduced model [ns]."""

    full: float
    reduced: float

    @property
    def ratio(self) -> float:
        """The reduced model's over the full one's."""
        return self.reduced / self.full


def saved_in(study: Study, full: str, reduced: str) -> Saved | None:
    """Cost of both models in a study, where it timed them."""
    found = [study.costs.get((LINE, name)) for name in (full, reduced)]
    one, other = (None if cost is None else cost.ns_per_step for cost in found)
    return Saved(one, other) if one and other else None


def timed(full: str, reduced: str) -> Saved | None:
    """Both models timed alone, trimmed of what is idle; None without the engine."""
    scene, (one, other) = find_scene(LINE), (find_method(name) for name in (full, reduced))
    engine = engine_of(one)
    if engine.trimming is None or not installed(engine):
        return None
    case = system_of(scene).case(scene)
    costs = [engine.trimming(case, m, STEP, STEPS, TURNS).ns_trimmed for m in (one, other)]
    return Saved(*costs)


def finding(study: Study) -> Finding | None:
    """What a step of each costs, and that the motion is the same."""
    pairs = PAIRS if study.profile == "full" else PAIRS[:1]
    tried = ((pair, saved_in(study, *pair) or timed(*pair)) for pair in pairs)
    found = [(pair, saved) for pair, saved in tried if saved is not None]
    if not found:
        return None
    rows = [
        row(method_cell(name), value(ns), value(saved.ratio if name == pair[1] else 1.0),
            value(off(LINE, name, STEP)))
        for pair, saved in found
        for name, ns in zip(pair, (saved.full, saved.reduced), strict=True)
    ]  # fmt: skip
    saved = found[0][1]
    heads = ("method", "ns per step", "over the full model", "relative error of Δx")
    return Finding(
        "capsule-saving",
        "On a line the reduced model says the same for less",
        "measured",
        f"A step of the reduced model costs {number(saved.ratio, 2)} of one of the full model: it "
        f"saves {number(100 * (1 - saved.ratio), 2)} %.",
        (
            "Along one line the body has one freedom, and Σ f Nᵢ is f (M+m) g: a sliding joint "
            "with friction loss in place of a free joint and three contacts. It knows no heading, "
            "no normal forces and no heave, and so cannot tell that any of them is wrong.",
        ),
        (Table(f"Cost of ca1, and its error at {short(STEP)} s", heads,
               tuple(rows)),),
        (),
        (f"plumbob validate --scenes {LINE} --methods {FULL},{REDUCED}",),
    )  # fmt: skip
