"""Abilities that some engines have beside running scenes. Each ability is a record with the
engine's function; the engine's package is imported when that function is called."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

from plumbob.analytic.schemes import Scheme
from plumbob.engines.method import Method
from plumbob.models.scene import Case

if TYPE_CHECKING:  # records of users' models, which most commands do not need
    from plumbob.analytic.reference import Array, Signals
    from plumbob.engines.drawn_mechanism import SceneDrawing
    from plumbob.engines.mechanism import Mechanism
    from plumbob.engines.own_contacts import ContactModel
    from plumbob.engines.own_holds import HeldModel
    from plumbob.engines.own_motion import Change, FileFix, FixPlace, OwnModel, Start
    from plumbob.engines.peer_model import Layout, PeerModel
    from plumbob.engines.stepper import EndDerivatives, SceneMechanism, State, Stepper
    from plumbob.models.gradient import Number

    Derivatives = Callable[[Number, Method, float], Mapping[str, float]]
    OfMechanisms = Callable[
        [Sequence[SceneMechanism], float, Method, float, float], EndDerivatives
    ]

ModelFields = Mapping[tuple[str, str], tuple[float, ...]]
"""Numbers of a model file, in SI units: {(field, name of the body, joint, geom or actuator):
numbers of the field}."""

Fields = Iterator[tuple[str, str, Any]]
"""Entries of `ModelFields` in the order in which a reader finds them: (field, name, numbers)."""


@dataclass(frozen=True)
class Trimming:
    """Cost of a step of three versions of one model: the complete model; the model with needless
    pipeline stages disabled; and the model as it is run, which also lacks parts without effect."""

    ns_default: float  # the complete model [ns of processor time per step]
    ns_flags: float  # needless stages disabled [ns]
    ns_trimmed: float  # as run [ns]
    identical: bool  # the three versions end in the same state, to the last bit
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
    error: str  # predicted error of a stopping distance, or of the motion
    cost: str  # cost compared with the default settings
    holds: str  # models and motions for which the predicted error is valid


@dataclass(frozen=True)
class Settings:
    """Settings of a method at a step, to paste, and the error predicted for it."""

    method: str
    step: float  # [s]
    stop_error_per_speed: float | None
    """Signed leading error of a stopping distance over the initial speed [s], of first order in the
    step. None if nothing is predicted or nothing slides."""
    snippets: tuple[Snippet, ...]


@dataclass(frozen=True)
class FileCheck:
    """Differences between a model file and a method's settings for the file's time step."""

    method: str
    step: float  # [s], the file's own
    # field, value in the file, value of the method
    differences: tuple[tuple[str, str, str], ...]
    warnings: tuple[str, ...]  # contacts that are unstable, or written for another step


@dataclass(frozen=True)
class SchemeOfCase:
    """Case, method -> the scheme of a step, if it depends on the case. Otherwise an engine does not
    have this ability, and `Method.scheme` holds."""

    of: Callable[[Case, Method], Scheme]


@dataclass(frozen=True)
class SecondRun:
    """A method that controls its local error -> another method of the engine, and a tolerance, that
    solve the same equations with a much smaller error."""

    of: Callable[[Method], tuple[Method, float]]


@dataclass(frozen=True)
class UserSettings:
    """A user's model file -> a method with the file's settings; raises ParameterError."""

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


WantedProperty = Literal["restitution", "penetration", "creep"]


@dataclass(frozen=True)
class WantedContact:
    """A property that a contact has to have, at a step and under a load."""

    name: WantedProperty
    value: float  # restitution, depth [m] or speed of creep [m/s]
    step: float | None  # [s]; None: the step of `file`
    speed: float  # [m/s] speed of the impact
    mass: float | None  # [kg] mass of the body; None: the pair's effective mass
    load: float | None  # [N] force of the contact; None: the weight of the mass
    file: Path | None = None  # model file with the pair
    pair: tuple[str, str] | None = None  # names of two geoms of `file`


@dataclass(frozen=True)
class ContactSettings:
    """Settings that give a contact a wanted property, and what steps make of it."""

    name: WantedProperty
    value: float
    step: float  # [s]
    mjcf: str  # lines to paste into a model file
    # Smallest value of the property; of a restitution, the smallest for all moments of an impact
    low: float
    high: float
    depth: float  # [m] largest depth: in the impact, or at rest
    speed: float  # [m/s] speed of the impact
    push: float  # [m/s^2] acceleration that the load gives the free body


@dataclass(frozen=True)
class SettingsForContacts:
    """A wanted property -> the settings of a contact; raises ParameterError."""

    find: Callable[[WantedContact], ContactSettings]


@dataclass(frozen=True)
class FileChecks:
    """A user's model file against a method's settings; raises ParameterError."""

    check: Callable[[Path, Method], FileCheck]


@dataclass(frozen=True)
class UserModels:
    """Users' models as audits need them. A model is a path or a compiled model. Each function
    raises ParameterError; `model`, `contacts` and `held` also raise NotCertifiable."""

    model: Callable[[Any, Start], OwnModel]
    """Model, start -> the model of its motion."""
    contacts: Callable[[Any, Start, str | None, float | None], ContactModel]
    """Model, start, name of a free body (None: the heaviest), friction coefficient (None: the
    model's) -> the body on its plane."""
    held: Callable[[Any, Start, str | None], HeldModel]
    """Model, start, name of a body (None: all that touch) -> the bodies at rest."""
    write_trimmed: Callable[[Path, Sequence[Change], Path], tuple[Change, ...]]
    """Model file, changes that leave parts out, file to write -> the changes that were written."""
    write_fixed: Callable[[Path, FileFix, Path], FixPlace]
    """Model file, advised changes, file to write -> the place of the options in the new file."""
    quiet: Callable[[], AbstractContextManager[Any]]
    """Returns a context in which the engine prints nothing and leaves no file."""


class MotionView(Protocol):
    """A model at its start, to be looked at."""

    @property
    def step(self) -> float: ...
    def show(self) -> None: ...
    def frames(self, marks: Sequence[int], width: int, height: int) -> Iterator[Array]: ...


@dataclass(frozen=True)
class Views:
    """Scenes and users' models to look at. Each function raises ParameterError, and Unsupported if
    there is nothing to show; `file` also raises NotCertifiable."""

    scene: Callable[[Case, Method, float], MotionView]
    """Case, method, step [s] -> the scene's model, driven as the scene is."""
    file: Callable[[Path, Start, Array | None, float], MotionView]
    """Model file, start, controls of shape (periods, actuators) or None, period [s] -> the
    model."""
    prepare: Callable[[], None]
    """Makes pictures without a window possible. It is called before a model is read."""


@dataclass(frozen=True)
class ModelReader:
    """A model file (MJCF) -> the fields that the engine's reader takes from it. If the reader
    refuses the file, the reader's exception is raised."""

    read: Callable[[Path], Fields]


@dataclass(frozen=True)
class RunsFiles:
    """Model file (MJCF), names of its joints and actuators, step [s] -> the model that the engine's
    reader makes, to be stepped beside MuJoCo's model. Raises NotRead, and exceptions of the
    reader."""

    load: Callable[[Path, Layout, float], PeerModel]
    precision: float = 2.0**-53  # relative rounding of the engine's numbers


@dataclass(frozen=True)
class PortsFiles:
    """Model files (MJCF) of users in ports of the engine, which step the engine's compiled
    models."""

    load: Callable[[Callable[[Any], Any], Path, Layout, float, Any], PeerModel]
    """A function from a compiled model to its port, the file, names of its joints and actuators,
    step [s], a compiled model of the file by another reader (None: the engine's own model) -> the
    file's model in the port, to be stepped beside the engine's model. Raises NotRead."""
    fields: Callable[[Any, Any], Fields]
    """A compiled model, another model with the same parts -> the fields of the first model, by the
    second model's names."""


@dataclass(frozen=True)
class BuildsMechanisms:
    """Mechanism, start, step [s] -> a stepper of the mechanism in the engine, by one method. Raises
    Unsupported, which names the part of the mechanism that the engine cannot express."""

    build: Callable[[Mechanism, State, float], Stepper]
    method: str  # name of the method that takes the steps, "engine/name"


@dataclass(frozen=True)
class Batches:
    """Case, method, step [s], number of worlds in a batch -> the device, and a function that takes
    a number of steps in all worlds and returns the wall time [s]. Raises Unsupported and
    ParameterError."""

    of: Callable[[Case, Method, float, int], tuple[str, Callable[[int], float]]]


class Copies(Protocol):
    """A compiled model in a port of MuJoCo, run in batches."""

    def run(self, states: Array, warm_starts: Array, controls: Array) -> Array:
        """Returns the states of the copies of a batch after each step, shape (copies, steps + 1,
        n), from `states`, shape (copies, n), and accelerations with which their solvers begin,
        shape (copies, nv), under controls, shape (copies, steps, nu)."""

    @property
    def port(self) -> Any:
        """The model alone, as `PortsFiles` takes it."""


@dataclass(frozen=True)
class RunsCopies:
    """Compiled model of a user, whether to compute in double precision -> copies of the model.
    Raises RefusedFile."""

    make: Callable[[Any, bool], Copies]
    doubles: tuple[bool, ...]  # the precisions that the engine has: whether each is double


@dataclass(frozen=True)
class StepsOfFiles:
    """Text of a model file whose contacts depend on the time step -> the text for a step [s]."""

    rewrite: Callable[[str, float], str]


@dataclass(frozen=True)
class OwnDerivative:
    """An engine's own derivatives of the end of a run: a number among the parameters, method,
    step [s] or tolerance -> {observable: derivative}. Raises Unsupported."""

    way: str  # name of the way
    of: Derivatives
    precision: float = 0.0  # bound on the relative rounding of a step's derivative
    # the same derivatives by other differences: their distance from `of` shows how large rounding
    # is
    beside: Derivatives | None = None
    of_mechanisms: OfMechanisms | None = None
    """Three mechanisms in which a number is a little smaller, as it is, and a little larger; how
    far the outer numbers are apart; method, step [s], duration [s] -> the derivatives of the end of
    the middle one's run; raises Unsupported. None if the way is for scenes alone."""


@dataclass(frozen=True)
class OwnFit:
    """An engine's own fit: a function from a place in the unit box, shape (p,), to residuals, shape
    (m,), and the place to start from -> the best place. Raises Unsupported."""

    way: str  # name of the way
    of: Callable[[Callable[[Array], Array], Array], Array]


@dataclass(frozen=True)
class CompilesScenes:
    """Compiles the model files of systems, for engines that build mechanisms and for ports."""

    mechanism: Callable[[Case], SceneMechanism]  # raises Unsupported and ParameterError
    drawing: Callable[[Case, int], SceneDrawing]
    """Case, number of samples -> the case as replays draw it. Raises Unsupported and
    ParameterError."""
    translation: Callable[[Case, Method, float], Any]
    """Case, method, step [s] -> the engine's compiled model of the case. Raises Unsupported and
    ParameterError."""
    model: Callable[[Case, Method, float], tuple[OwnModel, Callable[[Array], Signals]]]
    """Case, method, step [s] -> the model that is stepped, in the form of a user's model; and a
    function from states, shape (n, k), to the observables that are functions of the state, shape
    (n,) each. Raises Unsupported, ParameterError and NotCertifiable."""
