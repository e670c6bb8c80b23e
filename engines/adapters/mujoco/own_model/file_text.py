"""A model file with the options that leave out what it does not need: its own text, and an <option>
at its end, where the last one counts.

MuJoCo's own writer rounds what a compiled model is written from, which moves it.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco.options import collected
from plumbob.engines.own_motion import Change

END = "</mujoco>"


def write(source: Path, left_out: Sequence[Change], target: Path) -> tuple[Change, ...]:
    """Write the model file `source` without these to `target`, and return those that options leave
    out: geoms stay. Raises ParameterError where nothing is left, or it cannot be written, or would
    not compile there."""
    kept = tuple(c for c in left_out if not any(indices for _, indices, _ in c.sets))
    if not kept:
        what = "omitted: no option leaves out what this motion does not need"
        raise ParameterError("write trimmed", str(target), what)
    part = target.with_name(f".{target.stem}-{os.getpid()}.xml")
    try:
        text, _, after = source.read_text("utf-8").rpartition(END)
        part.write_text(f"{text}{tostring(_option(kept), 'unicode')}\n{END}{after}", "utf-8")
        with collected():
            mujoco.MjModel.from_xml_path(str(part))
        part.replace(target)
    except (OSError, ValueError) as error:
        what = f"beside the model, where the files are that it names ({error})"
        raise ParameterError("write trimmed", str(target), what) from None
    finally:
        part.unlink(missing_ok=True)
    return kept


def _option(changes: Sequence[Change]) -> Element:
    """The element with these changes of options."""
    option, flags = Element("option"), 0
    for field, _, value in (setting for change in changes for setting in change.sets):
        if field == "disableflags":
            flags |= int(value)
        else:
            option.set(field, f"{value:.12g}")
    names = {
        name.removeprefix("mjDSBL_").lower(): "disable"
        for name, bit in mujoco.mjtDisableBit.__members__.items()
        if name.startswith("mjDSBL_") and flags & int(bit)
    }
    if names:
        SubElement(option, "flag", names)
    return option
