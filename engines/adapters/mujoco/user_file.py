"""Reads users' model files: the compiled model, and a file's options and contacts as a method."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.adapters.mujoco import options, trial
from plumbob.engines.adapters.mujoco.methods import METHODS
from plumbob.engines.method import USER_METHOD, Method, Options, time_step
from plumbob.engines.own_motion import Start
from plumbob.models.border import must_be, regular_file

LARGEST_COMPILED = 1_000_000_000  # [bytes] largest .mjb file, which contains its meshes
ROOTS = ("mujoco",)  # elements with which a file may begin
USD = (".usd", ".usda", ".usdc", ".usdz")
HALVINGS = 6  # halvings of the file's step, to show whether a smaller step helps
# Options that decide how MuJoCo computes are taken from the file. Physical options (gravity, wind,
# density), the step, and options for the file's geoms stay those of the scene.
NUMERIC_OPTIONS = (
    "impratio",
    "ls_tolerance",
    "ccd_tolerance",
    "iterations",
    "ls_iterations",
    "noslip_iterations",
    "ccd_iterations",
)
DISABLE_FLAGS = (
    *("mjDSBL_EULERDAMP", "mjDSBL_REFSAFE", "mjDSBL_WARMSTART", "mjDSBL_ISLAND"),
    *("mjDSBL_MIDPHASE", "mjDSBL_NATIVECCD", "mjDSBL_MULTICCD"),
)
ENABLE_FLAGS = ("mjENBL_DIAGEXACT", "mjENBL_IPC")
CONDIMS = (1, 3, 4, 6)  # dimensions of a contact: no friction, sliding, torsional, rolling
# Fields of a geom that its contacts take. Friction stays as in the scene.
CONTACT_FIELDS = ("solref", "solimp", "condim", "margin", "gap")
# Fields that an option overrides in every contact
OVERRIDDEN_FIELDS = ("solref", "solimp", "margin")
# The solver's tolerances belong to the contacts: a scene's model scales them with its masses.
SOLVER_TOLERANCES = ("tolerance", "noslip_tolerance")


def user_method(path: str | Path) -> Method:
    """The method with the settings of a model file: its integrator, solver and other options, and
    its default contact parameters under "contact". The step sizes begin with the file's step.
    Raises ParameterError if the file holds no MJCF model."""
    spec = _read(path, "like")
    settings = {**_option_settings(spec), "contact": _contact_settings(spec)}
    _runnable(path, settings)
    step = time_step("like", spec.option.timestep, str(path))
    integrator = settings["integrator"]
    base_method = next(
        method for method in METHODS if method.settings["integrator"].lower() == integrator
    )
    scheme = base_method.scheme
    explicit_damping = settings["disableflags"] & mujoco.mjtDisableBit.mjDSBL_EULERDAMP
    if integrator == "euler" and explicit_damping:
        scheme = replace(scheme, implicit_damping=False)
    return replace(
        base_method,
        name=USER_METHOD,
        scheme=scheme,
        settings=settings,
        step_sizes=tuple(step / 2**halvings for halvings in range(HALVINGS + 1)),
        systems=(),
        kinds=(),
    )


def _option_settings(spec: Any) -> dict[str, Any]:
    """Returns the options of a model file that decide how MuJoCo computes."""
    option = spec.option
    settings: dict[str, Any] = {
        name: options.word(name, getattr(option, name)) for name in options.CHOICES
    }
    for name in NUMERIC_OPTIONS:
        if hasattr(option, name):
            settings[name] = _plain(getattr(option, name))
    settings["disableflags"] = _kept(option.disableflags, mujoco.mjtDisableBit, DISABLE_FLAGS)
    settings["enableflags"] = _kept(option.enableflags, mujoco.mjtEnableBit, ENABLE_FLAGS)
    return settings


def _contact_settings(spec: Any) -> dict[str, Any]:
    """Returns the contact parameters of a model file: its defaults, or the options that override
    them in every contact, and the solver's tolerances."""
    option = spec.option
    contact = {name: _plain(getattr(spec.default.geom, name)) for name in CONTACT_FIELDS}
    if option.enableflags & mujoco.mjtEnableBit.mjENBL_OVERRIDE:
        contact |= {name: _plain(getattr(option, f"o_{name}")) for name in OVERRIDDEN_FIELDS}
    return contact | {name: getattr(option, name) for name in SOLVER_TOLERANCES}


def compiled_model(path: Path, name: str, roots: Sequence[str] = ROOTS) -> Any:
    """The compiled model of the file `path`, which the argument `name` gave; raises
    ParameterError."""
    spec = _read(path, name, roots)
    with _refused(name, str(path), "a model that compiles"):
        model = spec.compile()
        bytes(model.names).decode("utf-8")
        return model


@contextmanager
def _refused(name: str, value: str, what: str) -> Iterator[None]:
    """Turns exceptions of MuJoCo's reader and compiler into a ParameterError: the argument `name`
    has this value, and must be `what`."""
    passing = ParameterError  # passes: its message names a part of the file
    with must_be(what, name, value, passing), trial.limited_memory(), options.collected():
        yield


def user_model(model: Any, start: Start) -> tuple[Any, str, Start]:
    """The compiled model of a user's model, which is a path, an MjSpec, an MjModel or an MjData;
    its name; and its start, which an MjData gives too. Raises ParameterError."""
    if isinstance(model, (str, Path)):
        return _of_file(Path(model)), str(model), start
    if isinstance(model, mujoco.MjData):
        qpos = model.qpos.tolist() if start.qpos is None else start.qpos
        qvel = model.qvel.tolist() if start.qvel is None else start.qvel
        return model.model, "model", replace(start, qpos=qpos, qvel=qvel)
    if isinstance(model, mujoco.MjSpec):
        with _refused("model", "MjSpec", "one that compiles"):
            return model.copy().compile(), "model", start
    if not isinstance(model, mujoco.MjModel):
        what = (
            "a path to a MuJoCo model file, a mujoco.MjModel, a mujoco.MjSpec, or a mujoco.MjData, "
            "which is the start too"
        )
        raise ParameterError("model", type(model).__name__, what)
    return model, "model", start


def _of_file(path: Path) -> Any:
    """The compiled model of an MJCF, URDF or compiled file; raises ParameterError."""
    if path.suffix in USD:
        what = "an MJCF, URDF or compiled (.mjb) file: no reader of USD is there"
        raise ParameterError("model", str(path), what)
    if path.suffix != ".mjb":
        return compiled_model(path, "model", ("mujoco", "robot"))
    regular_file("model", path, LARGEST_COMPILED)
    with _refused("model", str(path), "a model that this MuJoCo has compiled"):
        model = mujoco.MjModel.from_binary_path(str(path))
        # a trial within the limit on memory: data may need more than the model
        mujoco.MjData(model)
        return model


def _read(path: str | Path, name: str, roots: Sequence[str] = ROOTS) -> Any:
    """The `MjSpec` of the model file `path`, which the argument `name` gave; raises
    ParameterError."""
    regular_file(name, Path(path))
    with _refused(name, str(path), "a MuJoCo model file"):
        root = trial.checked(name, Path(path))
        spec = mujoco.MjSpec.from_file(str(path))
    if root not in roots:
        raise ParameterError(name, str(path), f"a MuJoCo model file (it begins with <{root}>)")
    return spec


def _runnable(path: str | Path, settings: Options) -> None:
    """Raises ParameterError if no model can have these settings."""
    contact = settings["contact"]
    if contact["condim"] not in CONDIMS:
        allowed = "a model whose default condim is 1, 3, 4 or 6"
        raise ParameterError("like", str(path), f"{allowed}, not {contact['condim']}")
    numbers = {name: settings[name] for name in NUMERIC_OPTIONS if name in settings} | contact
    for name, value in numbers.items():
        if not np.all(np.isfinite(value)):
            raise ParameterError("like", str(path), f"a model with finite numbers, not {name}")


def _plain(value: Any) -> float | int | tuple[float, ...]:
    """A number, or an array as a tuple of floats."""
    if isinstance(value, (int, float)):
        return value
    return tuple(float(number) for number in value)


def _kept(flags: int, kind: Any, names: tuple[str, ...]) -> int:
    """The bits of `flags` with these names. A name that this MuJoCo does not know has no bit."""
    return flags & sum(int(getattr(kind, name, 0)) for name in names)
