"""Methods and engines: names, declared order, and the functions that run them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.schemes import Scheme
from plumbob.engines.trajectory import Stepping as Stepping
from plumbob.engines.trajectory import Timed, Trajectory
from plumbob.models.registry import added_system, find_system
from plumbob.models.scene import Case, Scene

if TYPE_CHECKING:  # what an engine takes of a user's own model
    from plumbob.engines.own_contacts import ContactModel
    from plumbob.engines.own_motion import Change, OwnModel

USER_METHOD = "mujoco/mine"  # the method that `Engine.user_method` reads from a user's file


ModelFields = Mapping[tuple[str, str], tuple[float, ...]]
"""Of a model file: {(field, name of the body, joint, geom or actuator): its numbers}, SI."""


SHORTEST, LONGEST = 1e-9, 1e3  # [s] of a time step, whose inverse square contacts are as stiff as


def time_step(name: str, step: float, model: str = "") -> float:
    """Return a time step [s] that settings can be for, or that of a `model`, which the argument
    `name` gave; raises ParameterError where it is none."""
    if not SHORTEST <= step <= LONGEST:
        allowed = f"from {SHORTEST:g} to {LONGEST:g} s"
        if model:
            raise ParameterError(name, model, f"a model with a time step {allowed}, not {step:g}")
        raise ParameterError(name, step, allowed)
    return step


class Unsupported(Exception):
    """A method that cannot run a scene; its text is the reason, one line."""


@dataclass(frozen=True)
class Method:
    """An engine with its integrator and, where it matters, model variant and contact profile."""

    name: str  # "mujoco/rk4", "mujoco/euler+coulomb"
    scheme: Scheme  # what it does in a step, for the theory of errors
    order: int | None  # of the global error in the step; None for adaptive methods
    control: Literal["step", "tolerance"] = "step"  # what its `step` argument means: [s], or rtol
    settings: Mapping[str, Any] = field(default_factory=dict)  # the engine's own option names
    step_sizes: tuple[float, ...] = ()  # of tolerances, loose to tight; steps are the scene's own
    systems: tuple[str, ...] = ()
    """Patterns of systems, or scenes, it is meant for beside its kinds, or after "!" is not."""
    kinds: tuple[str, ...] = ()
    """Kinds of system that it can do; with no names of systems either: all."""
    surrogate: str = ""
    """Why its model is not the full body, where it is not: what no robot model can take over."""

    def __getstate__(self) -> dict[str, Any]:
        """The fields as a plain dict: a read-only view of one cannot be sent to a worker."""
        return {**self.__dict__, "settings": dict(self.settings)}

    @property
    def engine(self) -> str:
        """Name of the engine, the part before the slash."""
        return self.name.partition("/")[0]


def meant(method: Method, scene: Scene) -> bool:
    """Whether `method` is meant for `scene`: by the kind of its system, or by its name or its
    system's. A system of another package is for the engines that it has builders for, and the
    methods that name it."""
    names = (scene.system, scene.name)
    named = [p for p in method.systems if not p.startswith("!")]
    unwanted = [p[1:] for p in method.systems if p.startswith("!")]
    if any(fnmatchcase(name, pattern) for pattern in unwanted for name in names):
        return False
    if any(fnmatchcase(name, pattern) for pattern in named for name in names):
        return True
    added = added_system(scene.system)
    if added is not None and method.engine not in added.builders:
        return False
    if not method.kinds:
        return not named
    return (scene.kind or find_system(scene.system).kind) in method.kinds


class Simulation(Timed, Protocol):
    """A scene compiled for one method and step, ready to be run any number of times."""

    def run(self) -> Trajectory:
        """Run from the start to the end; the trajectory's `seconds` count the stepping alone."""
        ...


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
    holds: str  # where it holds


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
    differences: tuple[tuple[str, str, str], ...]  # field, value in the file, value of the method
    warnings: tuple[str, ...]  # contacts that are written for another step, or unstable


LIMITS = ("not-converging", "fail", "diverged", "pre-asymptotic", "unsupported")  # verdicts


@dataclass(frozen=True)
class KnownLimit:
    """A limit that another package declares for its engine on scenes of a pattern, in place of
    `pass` or `converges`."""

    scenes: str  # a shell pattern
    method: str  # its name
    verdict: str  # one of LIMITS
    reason: str
    size: float = 0.0
    """Relative error, known within a factor of two: the median over the finest five runs of the
    quick profile; of no meaning where the verdict is `unsupported`."""


@dataclass(frozen=True)
class Engine:
    """A translation of scenes into one engine's terms; the package is imported when it runs."""

    name: str
    package: str  # the import name that must be there
    methods: tuple[Method, ...]
    prepare: Callable[[Case, Method, float], Simulation]  # raises Unsupported
    model_error: Callable[[Case, Method, float], Mapping[str, Mapping[str, float]]]
    """{observable: {reason: absolute bound}}: what the model itself adds, apart from the step."""
    scheme: Callable[[Case, Method], Scheme] | None = None
    """What a method does in a step of a case, where that is not always the method's own scheme."""
    optional: bool = False  # a peer: not missed unless it is asked for by name
    not_read: Mapping[str, str] = field(default_factory=dict)
    """{observable: why}: what the engine gives of no scene."""
    distribution: str = ""  # the package that adds it, where that is not plumbob
    known_limits: tuple[KnownLimit, ...] = ()  # that an engine of another package declares
    confirming: Callable[[Method], tuple[Method, float]] | None = None
    """A method that controls its local error -> a method and tolerance of this engine, on the same
    equations, whose own error is much smaller."""
    contact_model: Callable[[Case, Method, float], object] | None = None
    """What the engine's contacts are at a step [s], as the record that theory takes (SoftContact,
    ...), or None where no theory covers them; does not import the engine's package."""
    user_method: Callable[[Path], Method] | None = None
    """A user's own model file -> the method with its settings; raises ParameterError."""
    trimming: Callable[[Case, Method, float, int, int], Trimming] | None = None
    """Case, method, step [s], number of steps, repeats -> what trimming the model saves; raises
    Unsupported."""
    settings_text: Callable[[Method, float, float | None, float], Settings] | None = None
    """Method, step [s], stiffness of contacts (natural frequency times step; None for the engine's
    own choice), friction coefficient -> what to paste into a model; raises ParameterError."""
    check_file: Callable[[Path, Method], FileCheck] | None = None
    """A user's model file against a method's settings; raises ParameterError."""
    own_model: Callable[[Any, int | str | None], OwnModel] | None = None
    """A user's model, a path or one that is compiled, and a keyframe -> the model as an audit needs
    it; raises ParameterError and NotCertifiable."""
    own_contacts: (
        Callable[[Any, int | str | None, str | None, float | None], ContactModel] | None
    ) = None
    """A user's model, a path or one that is compiled, a keyframe, a free body's name (None: the
    heaviest), a friction coefficient in place of its own -> the body on its plane; raises
    ParameterError and NotCertifiable."""
    write_trimmed: Callable[[Path, Sequence[Change], Path], tuple[Change, ...]] | None = None
    """A model file, what can be left out of it, and the file to write without it -> what of that is
    left out there; raises ParameterError."""
    model_fields: Callable[[Path], ModelFields] | None = None
    """A model file (MJCF) -> what the engine's own reader takes from it; raises what that raises
    where it refuses the file."""
    model_text: Callable[[str, float], str] | None = None
    """Text of a model file whose contacts go with the step -> the text for another step [s]."""
