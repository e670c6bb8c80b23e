"""What a scene's MuJoCo model leaves out, what that saves, and that the motion is the same."""

from __future__ import annotations

from collections.abc import Sequence

from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import engine_of, installed
from plumbob.models.registry import case_of
from plumbob.models.scene import Case, Scene
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
    from plumbob.engines.adapters.mujoco.saving import saving

    case, step = case_of(scene), scene.steps[len(scene.steps) // 2]
    rows = []
    try:
        for method in chosen:
            found = saving(case, method, step, STEPS, REPEATS)
            saved = 1.0 - found.ns_trimmed / found.ns_default
            rows.append(
                row(
                    Cell(method.name, "method"),
                    *(
                        Cell(notation.number(ns), "number")
                        for ns in (found.ns_default, found.ns_flags, found.ns_trimmed)
                    ),
                    Cell(f"{100 * saved:.0f} %", "number"),
                    Cell("identical to the last bit", "pass")
                    if found.identical
                    else Cell("differs", "fail"),
                )
            )
        left_out = _left_out(case, chosen[0], step)
    except Unsupported:
        return None
    heads = ("method", "everything in [ns per step]", "without idle stages", "as run", "saved",
             f"state after {STEPS} steps")  # fmt: skip
    return Table("What the model leaves out, and what that saves", heads, tuple(rows), left_out)


def _left_out(case: Case, method: Method, step: float) -> str:
    """The stages and parts that the model as run does without."""
    import mujoco

    from plumbob.engines.adapters.mujoco.simulation import compiled
    from plumbob.engines.adapters.mujoco.translation import builder

    run = compiled(case, method, step).model
    whole = builder(case.system).whole(case.system.mjcf, case.problem).compile()
    bits = mujoco.mjtDisableBit
    flags = [
        name.removeprefix("mjDSBL_").lower()
        for name, bit in bits.__members__.items()
        if name.startswith("mjDSBL_")
        and bit not in (bits.mjDSBL_AUTORESET,)
        and run.opt.disableflags & int(bit)
    ]
    parts = [
        notation.plural(getattr(whole, count) - getattr(run, count), word)
        for count, word in (("ngeom", "geom"), ("nmesh", "mesh"), ("njnt", "joint"))
        if getattr(whole, count) > getattr(run, count)
    ]
    text = f"Stages switched off, idle here: {', '.join(flags) or 'none'}. "
    return text + f"Parts that are seen and not felt, left out: {', '.join(parts) or 'none'}."
