"""Abilities that some engines have beside running scenes: a record for each, with the function that
has it. None imports the engine's package before it is called."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.schemes import Scheme
from plumbob.engines.method import Method
from plumbob.models.scene import Case

if TYPE_CHECKING:  # what an engine takes of a user's own model
    from plumbob.analytic.reference import Array
    from plumbob.engines.mechanism import Mechanism
    from plumbob.engines.own_contacts import ContactModel
    from plumbob.engines.own_motion import Change, OwnModel, Start
    from plumbob.engines.peer_model import Layout, PeerModel
    from plumbob.engines.stepper import EndDerivatives, SceneMechanism, State, Stepper
    from plumbob.models.gradient import Number

    Derivatives = Callable[[Number, Method, float], Mapping[str, float]]
    OfMechanisms = Callable[
        [Sequence[SceneMechanism], float, Method, float, float], EndDerivatives
    ]

ModelFields = Mapping[tuple[str, str], tuple[float, ...]]
"""Of a model file: {(field, name of the body, joint, geom or actuator): its numbers}, SI."""

Fields = Iterator[tuple[str, str, Any]]
"""The same as it is read: field, name, numbers."""


@dataclass(frozen=True)
class Trimming:
    """Cost of a step of three versions of one model: complete, with the pipeline stages disabled
    that have nothing to do in it, and as it is run, without the parts that have no effect too."""

    ns_default: float  # the complete model [ns of processor time per step]
    ns_flags: float  # needless stages disabled [ns]
    ns_trimmed: float  # as run [ns]
    identical: bool  # whether the three states at the end agree to the last bit
    stages_off: tuple[str, ...] = ()  # names of the disabled pipeline stages
    parts_left_out: tuple[str, ...] = ()  # counts with their words: "2 geoms", "1 mesh"

    @property
    def saved(self) -> float:
        """Fraction of the complete model's cost that is saved."""
        return 1.0 - self.ns_trimmed / self.ns_default


@dataclass(frozen=True)
class Snippet:
    """One way to give a model of one's own the settings of a method, ready to paste."""

    title: str
    mjcf: str  # lines of a model file; may be empty
    python: str  # lines to run after the model is compiled or built; may be empty
    error: str  # what is predicted of a stopping distance, or of the motion
    cost: str
    holds: str  # the models and motions for which the predicted error is valid


@dataclass(frozen=True)
class Settings:
    """Settings of a method at a step, to paste, and the error predicted for it."""

    method: str
    step: float  # [s]
    stop_error_per_speed: float | None
    """Leading error of a stopping distance over the initial speed [s], of first order in the step
    and signed; None where nothing is predicted or nothing slides."""
    snippets: tuple[Snippet, ...]


@dataclass(frozen=True)
class FileCheck:
    """How a model file compares with a method's settings for the file's own time step."""

    method: str
    step: float  # [s], the file's own
    differences: tuple[
        tuple[str, str, str], ...
    ]  # field, value in the file, value of the method
    warnings: tuple[str, ...]  # contacts that are written for another step, or unstable


@dataclass(frozen=True)
class SchemeOfCase:
    """The scheme of a method in a step of a case, where that is not always the method's own."""

    of: Callable[[Case, Method], Scheme]


@dataclass(frozen=True)
class SecondRun:
    """A method that controls its local error -> a method and tolerance of the engine, on the same
    equations, whose own error is much smaller."""

    of: Callable[[Method], tuple[Method, float]]


@dataclass(frozen=True)
class UserSettings:
    """A user's own model file -> the method with its settings; raises ParameterError."""

    read: Callable[[Path], Method]


@dataclass(frozen=True)
class Ablation:
    """Case, method, step [s], number of steps, repeats -> what trimming the model saves; raises
    Unsupported."""

    measure: Callable[[Case, Method, float, int, int], Trimming]


@dataclass(frozen=True)
class SettingsToPaste:
    """Method, step [s], stiffness of contacts (natural frequency times step; None for the engine's
    own choice), friction coefficient -> what to paste into a model; raises ParameterError."""

    write: Callable[[Method, float, float | None, float], Settings]


@dataclass(frozen=True)
class FileChecks:
    """A user's model file against a method's settings; raises ParameterError."""

    check: Callable[[Path, Method], FileCheck]


@dataclass(frozen=True)
class UserModels:
    """Models of a user's own, a path or one that is compiled, as audits need them; each raises
    ParameterError, and the first two NotCertifiable."""

    model: Callable[[Any, Start], OwnModel]
    """Model, start -> the model of its motion."""
    contacts: Callable[[Any, Start, str | None, float | None], ContactModel]
    """Model, start, a free body's name (None: the heaviest), a friction coefficient in place of
    its own -> the body on its plane."""
    write_trimmed: Callable[[Path, Sequence[Change], Path], tuple[Change, ...]]
    """Model file, what can be left out of it, and the file to write without it -> what of that is
    left out there."""
    quiet: Callable[[], AbstractContextManager[Any]]
    """Returns a context in which the engine prints nothing and leaves no file."""


@dataclass(frozen=True)
class ModelReader:
    """A model file (MJCF) -> what the engine's own reader takes from it, SI: field, name of the
    body, joint, geom or actuator, and its numbers; raises what that raises where it refuses the
    file."""

    read: Callable[[Path], Fields]


@dataclass(frozen=True)
class RunsFiles:
    """Model file (MJCF), names of its joints and actuators, step [s] -> the model as the engine's
    own reader makes it, to be stepped beside MuJoCo's; raises what that raises, and NotRead."""

    load: Callable[[Path, Layout, float], PeerModel]
    precision: float = 2.0**-53  # relative rounding of its numbers


@dataclass(frozen=True)
class BuildsMechanisms:
    """A mechanism, the state in which it starts, step [s] -> the mechanism in the engine, to be
    stepped by one method of its own; raises Unsupported, which names the part of the mechanism that
    the engine does not express."""

    build: Callable[[Mechanism, State, float], Stepper]
    method: str  # its name, "engine/name"


@dataclass(frozen=True)
class Batches:
    """Case, method, step [s], number of worlds that run beside each other -> the device, and a
    function that takes so many steps of all of them and returns the wall time [s]; raises
    Unsupported and ParameterError."""

    of: Callable[[Case, Method, float, int], tuple[str, Callable[[int], float]]]


@dataclass(frozen=True)
class StepsOfFiles:
    """Text of a model file whose contacts go with the step -> the text for another step [s]."""

    rewrite: Callable[[str, float], str]


@dataclass(frozen=True)
class OwnDerivative:
    """A way of an engine's own to derivatives of the end of a run: a number among the parameters,
    method, step [s] or tolerance -> {observable: derivative}; raises Unsupported."""

    way: str
    of: Derivatives
    precision: float = 0.0  # relative, a step: what its own differences leave, a bound
    # the same by others, which tell how large their rounding is
    beside: Derivatives | None = None
    of_mechanisms: OfMechanisms | None = None
    """Three mechanisms in which a number is a little smaller, as it is, and a little larger; how
    far the outer numbers are apart; method, step [s], duration [s] -> the derivatives of the end of
    the middle one's run; raises Unsupported. None if the way is for scenes alone."""


@dataclass(frozen=True)
class OwnFit:
    """A fit of an engine's own: residuals of a place in the unit box, shape (p,) -> (m,), and the
    place to start from -> the best place; raises Unsupported."""

    way: str
    of: Callable[[Callable[[Array], Array], Array], Array]


@dataclass(frozen=True)
class CompilesScenes:
    """Compiles the model files of systems, for engines that build mechanisms and for ports."""

    mechanism: Callable[[Case], SceneMechanism]  # raises Unsupported and ParameterError
    translation: Callable[[Case, Method, float], Any]
    """A case at a step [s] in the engine's own terms; raises Unsupported and ParameterError."""
