"""What a scene's MuJoCo model leaves out, what that saves, and that the motion is the same."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import engine_of, installed
from plumbob.engines.trimming import Trimming
from plumbob.models.registry import case_of
from plumbob.models.scene import Scene
from plumbob.reports.view import notation
from plumbob.reports.view.content import Cell, Table, row

STEPS, REPEATS = 300, 7  # of a timing: enough for a ratio within a few per cent


def trimming(scene: Scene, methods: Sequence[Method]) -> Table | None:
    """Cost of a step with everything in, without idle stages, and without unfelt geoms too, for
    one method of each scheme among `methods`, those that run the scene; None where MuJoCo does
    not."""
    schemes = {m.scheme: m for m in reversed(methods) if m.engine == "mujoco"}
    chosen = [m for m in methods if m in schemes.values()]
    if not chosen or not installed(engine_of(chosen[0])):
        return None
    timed = engine_of(chosen[0]).trimming
    if timed is None:
        return None
    case, step = case_of(scene), scene.steps[len(scene.steps) // 2]
    rows: list[tuple[Cell, ...]] = []
    first: Trimming | None = None
    try:
        for method in chosen:
            found = timed(case, method, step, STEPS, REPEATS)
            first = first or found
            rows.append(
                row(
                    Cell(method.name, "method"),
                    *(
                        Cell(notation.number(ns), "number")
                        for ns in (found.ns_default, found.ns_flags, found.ns_trimmed)
                    ),
                    Cell(f"{100 * found.saved:.0f} %", "number"),
                    Cell("identical to the last bit", "pass")
                    if found.identical
                    else Cell("differs", "fail"),
                )
            )
    except Unsupported:
        return None
    heads = ("method", "everything in [ns per step]", "without idle stages", "as run", "saved",
             f"state after {STEPS} steps")  # fmt: skip
    return Table(
        "What the model leaves out, and what that saves",
        heads,
        tuple(rows),
        "" if first is None else _left_out(first),
    )


def _left_out(found: Trimming) -> str:
    """The stages and parts that the model as run does without."""
    text = f"Stages switched off, idle here: {', '.join(found.stages_off) or 'none'}. "
    parts = ", ".join(found.parts_left_out) or "none"
    return text + f"Parts that are seen and not felt, left out: {parts}."
