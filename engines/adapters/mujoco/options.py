"""Sets a method's options, finds stages that a model does not need, and collects MuJoCo's log."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from types import MappingProxyType
from typing import Any

import mujoco
import numpy as np

from plumbob.engines.method import Options, Unsupported
from plumbob.engines.own_motion import NotCertifiable

BIT = mujoco.mjtDisableBit
# {option: (its enumeration, the prefix of the enumeration's names)}
CHOICES: Mapping[str, tuple[type[Any], str]] = MappingProxyType(
    {
        "integrator": (mujoco.mjtIntegrator, "mjINT_"),
        "cone": (mujoco.mjtCone, "mjCONE_"),
        "solver": (mujoco.mjtSolver, "mjSOL_"),
        "jacobian": (mujoco.mjtJacobian, "mjJAC_"),
    }
)
# settings that are no options of MuJoCo: builders and runs read them
ELSEWHERE = (
    *("contact", "control_at", "height", "model", "slider_ahead"),
    *("drive_rate", "platform_armature", "reads_acceleration", "reads_energy"),
)


def apply(spec: mujoco.MjSpec, settings: Options, step: float) -> None:
    """Sets the time step [s] and the options named in `settings` on `spec`. Raises Unsupported if
    the installed release of MuJoCo lacks an option or one of its values."""
    spec.option.timestep = step
    for option, value in settings.items():
        if option in ELSEWHERE:
            continue
        chosen = value
        if option in CHOICES:
            numbers = [int(number) for number in CHOICES[option][0].__members__.values()]
            known = {word(option, number): number for number in numbers}
            chosen = known.get(str(value).lower())
            if chosen is None:
                raise _not_in_release(f"{option} {value!r}")
        elif not hasattr(spec.option, option):
            raise _not_in_release(f"option {option}")
        setattr(spec.option, option, chosen)


def _not_in_release(what: str) -> Unsupported:
    """Returns the error for something that the installed release of MuJoCo lacks."""
    return Unsupported(f"MuJoCo {mujoco.__version__} has no {what}")


def word(option: str, value: float) -> str:
    """The value of an option as a user writes it."""
    if option not in CHOICES:
        return f"{value:g}"
    kind, prefix = CHOICES[option]
    return str(kind(int(value)).name.removeprefix(prefix).lower())


def integrator_number(integrator: str) -> Any:
    """MuJoCo's number of an integrator."""
    return getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")


def numbers_text(values: Iterable[float]) -> str:
    """Numbers as MJCF writes them."""
    return " ".join(f"{value:g}" for value in values)


def needless_stages(model: mujoco.MjModel) -> int:
    """The disable flags of the pipeline stages that have no effect in `model`, in any state."""
    collides = _any(model, "geom_contype", "geom_conaffinity") or model.npair or model.nflex
    limited = _any(model, "jnt_limited", "tendon_limited")
    constrained = collides or limited or model.neq or _present(model, "frictionloss")
    fluid = model.opt.density or model.opt.viscosity
    # With both flags set, MuJoCo skips all passive forces, and not only springs and dampers.
    passive = fluid or model.nflex or model.nplugin or _any(model, "body_gravcomp")
    has_no_effect = {
        BIT.mjDSBL_CONTACT: not collides,
        BIT.mjDSBL_CONSTRAINT: not constrained,
        BIT.mjDSBL_ACTUATION: not (model.nu or model.nplugin),
        BIT.mjDSBL_SPRING: not (passive or _present(model, "stiffness")),
        BIT.mjDSBL_DAMPER: not (passive or _present(model, "damping")),
        BIT.mjDSBL_SENSOR: not model.nsensor,
    }
    return sum(int(bit) for bit, needless in has_no_effect.items() if needless)


def disabled(flags: int) -> tuple[str, ...]:
    """The names of the stages that disable flags leave out."""
    bits = BIT.__members__.items()
    left_out = (name for name, bit in bits if name.startswith("mjDSBL_") and flags & int(bit))
    return tuple(name.removeprefix("mjDSBL_").lower() for name in left_out)


def _any(model: mujoco.MjModel, *fields: str) -> bool:
    """Whether any of these fields of a model has an entry that is not zero."""
    return any(bool(np.any(getattr(model, field))) for field in fields)


def _present(model: mujoco.MjModel, word: str) -> bool:
    """Whether any field of the model whose name contains `word` has an entry that is not zero."""
    return _any(model, *_named_after(word))


@cache
def _named_after(word: str) -> tuple[str, ...]:
    """The fields of a model whose names contain a word."""
    return tuple(field for field in dir(mujoco.MjModel) if word in field)


@contextmanager
def collected() -> Iterator[list[str]]:
    """Collects MuJoCo's log messages and compiler warnings while the block runs; nothing is printed
    or written to disk. Raises NotCertifiable if MuJoCo gives up a model with a fatal error."""
    messages: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(messages.append)
    try:
        with enough_memory(), warnings.catch_warnings(record=True) as compiling:
            warnings.simplefilter("always", UserWarning)
            yield messages
    except mujoco.FatalError as error:
        raise NotCertifiable(f"MuJoCo gives it up: {error}") from None
    finally:
        mujoco.set_mju_user_warning(before)
        messages += [str(warning.message) for warning in compiling]


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The compiled model; raises Unsupported if MuJoCo refuses it."""
    try:
        with enough_memory():
            return spec.compile()
    except ValueError as error:
        raise Unsupported(f"MuJoCo refuses the model: {' '.join(str(error).split())}") from None


@contextmanager
def enough_memory() -> Iterator[None]:
    """Turns MuJoCo's errors for exhausted memory into MemoryError."""
    try:
        yield
    except (ValueError, mujoco.FatalError) as error:
        if "allocate memory" in str(error):
            raise MemoryError(str(error)) from error
        raise
