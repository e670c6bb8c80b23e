"""MuJoCo as an engine: its methods and abilities.

MuJoCo, and the modules that need it, are imported when one of these functions is called.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.schemes import Scheme
from plumbob.engines.abilities import (
    Ablation,
    CompilesScenes,
    ContactSettings,
    Fields,
    FileCheck,
    FileChecks,
    ModelReader,
    OwnDerivative,
    OwnFit,
    PortsFiles,
    SchemeOfCase,
    Settings,
    SettingsForContacts,
    SettingsToPaste,
    StepsOfFiles,
    Trimming,
    UserModels,
    UserSettings,
    Views,
    WantedContact,
)
from plumbob.engines.adapters.mujoco.methods import METHODS
from plumbob.engines.method import Engine, Method, Simulation
from plumbob.engines.registry import builder, model_error
from plumbob.engines.trajectory import ByName
from plumbob.models.scene import FREE_ROTATION, ON_PLANE, SMOOTH, Case

if TYPE_CHECKING:
    from plumbob.analytic.reference import Array, Signals
    from plumbob.engines.abilities import MotionView
    from plumbob.engines.drawn_mechanism import SceneDrawing
    from plumbob.engines.own_contacts import ContactModel
    from plumbob.engines.own_holds import HeldModel
    from plumbob.engines.own_motion import Change, FileFix, FixPlace, OwnModel, Start
    from plumbob.engines.peer_model import Layout, PeerModel
    from plumbob.engines.stepper import SceneMechanism
    from plumbob.models.gradient import Number


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Returns the simulation of `case` by `method` at `step` [s]; raises Unsupported and
    ParameterError."""
    from plumbob.engines.adapters.mujoco.simulation import compiled

    return compiled(case, method, step)


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on a case.

    - Free rotation, loops and contacts: the builder of the system names the scheme.
    - A servo with Euler: the motor's damping is explicit, the joint's implicit.
    - A single free body that moves and turns, with implicitfast: the step takes velocity
      derivatives of centripetal forces, as `implicit` does. It is of first order; no theory here
      covers it.
    - Otherwise: the method's own scheme.
    """
    if case.system.kind in (FREE_ROTATION, SMOOTH, ON_PLANE):
        builder_scheme = getattr(builder("mujoco", case.system), "scheme", None)
        return method.scheme if builder_scheme is None else builder_scheme(method)
    integrator = str(method.settings.get("integrator")).lower()
    if case.system.name == "servo" and integrator == "euler":
        return replace(method.scheme, implicit_damping=case.problem.joint_part)
    free_body = case.system.name == "capsule-coast" and case.problem.motion.kind == "plane"
    if integrator == "implicitfast" and free_body:
        return Scheme("implicitfast on a free body")
    return method.scheme


def _user_method(path: Path) -> Method:
    """Returns the method with the settings of a user's model file; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.user_file import user_method

    return user_method(path)


def _measure_trimming(
    case: Case, method: Method, step: float, steps: int, repeats: int
) -> Trimming:
    """Returns what trimming the model of a case saves in steps of `step` [s]; raises Unsupported
    and ParameterError."""
    from plumbob.engines.adapters.mujoco.trimming import trimming

    return trimming(case, method, step, steps, repeats)


def _settings(
    method: Method, step: float, stiffness: float | None, friction: float
) -> Settings:
    """Returns the settings to paste for `method` at `step` [s]; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.settings_to_paste import settings

    return settings(method, step, stiffness, friction)


def _settings_for_contacts(wanted: WantedContact) -> ContactSettings:
    """Returns the settings that give a contact a wanted property; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.settings_for_contacts import contact_settings

    return contact_settings(wanted)


def _mechanism_of_scene(case: Case) -> SceneMechanism:
    """Returns the mechanism of a case; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.mujoco.scene_mechanism import scene_mechanism

    return scene_mechanism(case)


def _drawing_of_scene(case: Case, samples: int) -> SceneDrawing:
    """Returns a case as replays draw it; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.mujoco.scene_mechanism import scene_drawing

    return scene_drawing(case, samples)


def _translate(case: Case, method: Method, step: float) -> Any:
    """Returns the Translation of a case at `step` [s]; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.mujoco.translation import translated

    return translated(case, method, step)


def _model_of_scene(
    case: Case, method: Method, step: float
) -> tuple[OwnModel, Callable[[Array], Signals]]:
    """Returns the model that is stepped of a case at `step` [s], and a function from states, shape
    (n, k), to observables, shape (n,) each. Raises Unsupported, ParameterError and
    NotCertifiable."""
    from plumbob.engines.adapters.mujoco.own_model.scene_model import scene_model

    return scene_model(case, method, step)


def _check_file(path: Path, method: Method) -> FileCheck:
    """Returns the differences of a model file from a method's settings; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.file_check import check

    return check(path, method)


def _rewrite_for_step(text: str, step: float) -> str:
    """Returns the text of one of plumbob's model files with contacts for `step` [s]."""
    from plumbob.engines.adapters.mujoco.settings_to_paste import rewritten

    return rewritten(text, step)


def _read_fields(path: Path) -> Fields:
    """Returns the fields of a model file as MuJoCo reads them; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.model_fields import model_fields

    return model_fields(path)


def _fields_of_port(model: Any, named: Any) -> Fields:
    """Returns the fields of a compiled model, by the names of another model with the same parts."""
    from plumbob.engines.adapters.mujoco.model_fields import fields_in

    return fields_in(model, named)


def _file_in_port(
    make: Callable[[Any], Any], path: Path, layout: Layout, step: float, read: Any
) -> PeerModel:
    """Returns a model file in a port, see `PortsFiles.load`."""
    from plumbob.engines.adapters.mujoco.terms import PortedModel

    return PortedModel(make, path, layout, step, read)


def _transition_derivatives(
    number: Number, method: Method, step: float, beside: bool = False
) -> ByName:
    """Returns derivatives of the end of a run by mjd_transitionFD; raises Unsupported. If `beside`,
    the differences have another size."""
    from plumbob.engines.adapters.mujoco.transition import transition

    return transition(number, method, step, beside)


def _inverse_derivatives(
    number: Number, method: Method, step: float, beside: bool = False
) -> ByName:
    """Returns derivatives of the end of a run by mjd_inverseFD; raises Unsupported. If `beside`,
    the differences have another size."""
    from plumbob.engines.adapters.mujoco.transition import inverse

    return inverse(number, method, step, beside)


def _fit(residuals: Callable[[Array], Array], start: Array) -> Array:
    """Returns the place in the unit box, shape (p,), with the smallest sum of squares of
    `residuals`, by mujoco.sysid from a `start`; raises Unsupported."""
    from plumbob.engines.adapters.mujoco.sysid import fit

    return fit(residuals, start)


def _user_model(model: Any, start: Start) -> OwnModel:
    """Returns a user's model as audits need it; raises ParameterError and NotCertifiable."""
    from plumbob.engines.adapters.mujoco.own_model.model import model_of_own

    return model_of_own(model, start)


def _user_contacts(
    model: Any, start: Start, body: str | None, friction: float | None
) -> ContactModel:
    """Returns a free body of a user's model on its plane; raises ParameterError and
    NotCertifiable."""
    from plumbob.engines.adapters.mujoco.own_model.user_contacts import own_contacts

    return own_contacts(model, start, body, friction)


def _user_held_bodies(model: Any, start: Start, body: str | None) -> HeldModel:
    """Returns the bodies of a user's model at rest; raises ParameterError and NotCertifiable."""
    from plumbob.engines.adapters.mujoco.own_model.held_bodies import held_bodies

    return held_bodies(model, start, body)


def _write_trimmed(source: Path, changes: Sequence[Change], target: Path) -> tuple[Change, ...]:
    """Writes the file `source` to `target` without the parts that `changes` leave out, and returns
    the changes that were written; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.own_model.file_text import write_without

    return write_without(source, changes, target)


def _write_fixed(source: Path, fix: FileFix, target: Path) -> FixPlace:
    """Writes the file `source` to `target` with the changes that an audit advises, and returns the
    place of the options in it; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.own_model.file_text import write_fixed

    return write_fixed(source, fix, target)


def _view_of_scene(case: Case, method: Method, step: float) -> MotionView:
    """Returns a case to look at; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.mujoco.viewing import view_of_scene

    return view_of_scene(case, method, step)


def _view_of_file(
    path: Path, start: Start, controls: Array | None, period: float
) -> MotionView:
    """Returns a user's model to look at; raises ParameterError and NotCertifiable."""
    from plumbob.engines.adapters.mujoco.own_model.file_view import view_of_file

    return view_of_file(path, start, controls, period)


def _choose_platform() -> None:
    """Chooses how pictures are rendered; raises Unsupported."""
    from plumbob.engines.adapters.mujoco.offscreen import choose_platform

    choose_platform()


def _collect_messages() -> AbstractContextManager[list[str]]:
    """Returns a context in which MuJoCo's messages are collected, and not printed."""
    from plumbob.engines.adapters.mujoco.options import collected

    return collected()


ENGINE = Engine(
    "mujoco",
    "mujoco",
    METHODS,
    prepare,
    model_error,
    abilities=(
        SchemeOfCase(scheme),
        UserSettings(_user_method),
        Ablation(_measure_trimming),
        SettingsToPaste(_settings),
        SettingsForContacts(_settings_for_contacts),
        CompilesScenes(_mechanism_of_scene, _drawing_of_scene, _translate, _model_of_scene),
        FileChecks(_check_file),
        StepsOfFiles(_rewrite_for_step),
        ModelReader(_read_fields),
        PortsFiles(_file_in_port, _fields_of_port),
        OwnDerivative(
            "transition",
            _transition_derivatives,
            beside=partial(_transition_derivatives, beside=True),
        ),
        OwnDerivative(
            "inverse", _inverse_derivatives, beside=partial(_inverse_derivatives, beside=True)
        ),
        OwnFit("sysid", _fit),
        Views(_view_of_scene, _view_of_file, _choose_platform),
        UserModels(
            _user_model,
            _user_contacts,
            _user_held_bodies,
            _write_trimmed,
            _write_fixed,
            _collect_messages,
        ),
    ),
)
