"""The page's section on the capsule held by friction: how far it creeps."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.study.results import Study
from plumbob.models.registry import scenes as find_scenes
from plumbob.models.scene import Scene
from plumbob.reports.findings.capsule.cells import method as method_cell
from plumbob.reports.findings.capsule.cells import value
from plumbob.reports.findings.capsule.runs import measured, names
from plumbob.reports.view.content import Cell, Figure, Finding, Section, Table, row
from plumbob.reports.view.notation import number, short

STEP = 1e-3  # [s]
USED_UP = "capsule-hold/0.999"
SLIDES = 0.1  # [m]: more than any creep, in ten seconds


def findings(study: Study) -> Sequence[Finding]:
    """Creep of each method in metres and metres a second, at each fraction that was run."""
    tilted = [s for s in find_scenes("capsule-hold") if s.name in {o.name for o in study.scenes}]
    tilted = [s for s in tilted if "length" not in s.parameters]
    if not tilted:
        return ()
    rows, held = [], {}
    for name in names(study):
        ways = [_crept(study, scene.name, name) for scene in tilted]
        if all(way is None for way in ways):
            continue
        held[name] = ways[-1]
        cells = [cell for way, scene in zip(ways, tilted, strict=True)
                 for cell in _pair(way, scene.duration)]  # fmt: skip
        rows.append(row(method_cell(name), *cells))
    heads = ("method", *(
        f"{scene.name.partition('/')[2]} of the threshold: {what}"
        for scene in tilted for what in ("way in 10 s [m]", "creep [m/s]")
    ))  # fmt: skip
    return (
        _finding(Table(f"Creep at a step of {short(STEP)} s", heads, tuple(rows)), tilted, held),
    )


def _finding(table: Table, tilted: Sequence[Scene], held: dict[str, float | None]) -> Finding:
    last = tilted[-1].name
    good = [w for n, w in held.items() if w is not None and n.endswith(("coulomb", "feet", "side"))]
    still = [w for n, w in held.items() if w is not None and n.endswith("coulomb+noslip")]
    slid = [n for n, w in held.items() if w is not None and w > SLIDES]
    said = f"In 10 s at {last.partition('/')[2]} of the largest tilt"
    if good:
        said += f" friction that converges creeps by at most {number(max(good), 2)} m"
    if still:
        said += f", with noslip by {number(max(still), 2)} m"
    if slid:
        said += f"; on {', '.join(slid)} the body slides away"
    return Finding(
        "capsule-creep",
        "Friction that holds creeps, and the contact decides by how much",
        "measured",
        f"{said}.",
        (
            "Gravity is tilted by the fraction of the angle that friction can hold, with the "
            "slider fixed. MuJoCo's friction at rest is a damper: speed over force is its "
            "regularisation, which a larger impratio, or a smaller step where the contact goes "
            "with it, makes smaller and nothing makes zero but noslip. A pyramid holds 0.71 of the "
            "friction between its edges, and slides under 0.9 of the threshold at 40°. pymunk's "
            "joints and contacts hold to rounding; three bare pivots do not share the load and "
            "let go.",
        ),
        (table,),
        (),
        ("plumbob validate --profile full --scenes 'capsule-hold/0*' --methods mujoco,pymunk",
         f"plumbob run {USED_UP} mujoco/euler+coulomb --step 1e-3"),
    )  # fmt: skip


def _crept(study: Study, scene: str, method: str) -> float | None:
    found = measured(study, scene, method, STEP)
    return None if found is None else abs(found.errors["displacement"].end)


def _pair(way: float | None, duration: float) -> tuple[Cell, Cell]:
    """The way and the mean speed; what slides away has no speed of creep."""
    if way is not None and way > SLIDES:
        return Cell("slides", "number", f"by {number(way)} m"), Cell("", "number")
    return value(way, 2), value(None if way is None else way / duration, 2)


def _figures(study: Study) -> Sequence[tuple[str, Sequence[Figure]]]:
    return ()


def _hard(study: Study, scene: Scene) -> Sequence[Figure | Table]:
    return ()


SECTION = Section(findings, _figures, _hard)
