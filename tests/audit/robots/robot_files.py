"""Model files that other packages distribute: found where they are installed, not imported."""

import importlib.util
from pathlib import Path

import mujoco

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import audited
from plumbob.engines.audit.controls import script

ASSETS = {"dm_control": "suite", "gymnasium": "envs/mujoco/assets"}


def folder(package):
    """Where an installed package has its model files; None where it is not installed."""
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        return None
    return Path(spec.submodule_search_locations[0]) / ASSETS[package]


FILES = [path for at in filter(None, map(folder, ASSETS)) for path in sorted(at.glob("*.xml"))]


def file_model(path):
    """A file, made ready for an audit; raises NotCertifiable."""
    return own_model(mujoco.MjModel.from_xml_path(str(path)), path.name)


def file_audit(path, control, budget):
    """The audit of a file; `budget` is processor time [s], which other work does not change."""
    own = file_model(path)
    return audited(own, script(own, control), control, Allowance(budget))
