"""A URDF file as MuJoCo's importer reads it, and the elements that it drops."""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from xml.etree import ElementTree

# {name of a dropped part: its place in the file}. Limits of force, friction, damping and mimic are
# kept.
DROPPED = MappingProxyType(
    {
        "velocity limits": "joint/limit[@velocity]",
        "soft limits": "joint/safety_controller",
        "calibration": "joint/calibration",
        "transmissions": "transmission",
        "gazebo": "gazebo",
    }
)


def file_format(path: Path) -> str:
    """Returns the format of a model file: "mjcf", "urdf", or "extended urdf" if the URDF has an
    element `<mujoco>`, from which MuJoCo's importer reads options."""
    root = ElementTree.parse(path).getroot()
    if root.tag != "robot":
        return "mjcf"
    return "urdf" if root.find("mujoco") is None else "extended urdf"


def urdf_notes(path: Path) -> tuple[str, ...]:
    """Returns remarks on a model file, if it is URDF: the parts that are dropped, and the link that
    is fixed."""
    root = ElementTree.parse(path).getroot()
    if root.tag != "robot":
        return ()
    dropped = [what for what, where in DROPPED.items() if root.find(where) is not None]
    children = {child.get("link") for child in root.iterfind("joint/child")}
    bases = [link.get("name", "") for link in root.iterfind("link")]
    bases = [name for name in bases if name not in children]
    read = f"URDF, read without {', '.join(dropped)}" if dropped else "URDF, read as it stands"
    return (f"{read}; {', '.join(bases)} fixed in the world",)
