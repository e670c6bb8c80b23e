"""MuJoCo as an engine: its methods, and the functions for the rest of plumbob.

Every function imports MuJoCo, or the module that needs it, when it is called.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbob.analytic.errors.contact_models.soft_contact import SoftContact
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.schemes import Scheme
from plumbob.analytic.systems.capsule_setup import CapsuleProblem
from plumbob.engines.abilities import (
    Ablation,
    ContactRecord,
    FileCheck,
    FileChecks,
    ModelFields,
    ModelReader,
    OwnDerivative,
    SchemeOfCase,
    Settings,
    SettingsToPaste,
    StepsOfFiles,
    Trimming,
    UserModels,
    UserSettings,
)
from plumbob.engines.adapters.mujoco.methods import METHODS
from plumbob.engines.method import Engine, Method, ModelError, Simulation
from plumbob.engines.own_contacts import ContactModel
from plumbob.engines.own_motion import AS_IT_STANDS, Change, OwnModel, Policy, Start
from plumbob.models.scene import Case

if TYPE_CHECKING:
    from plumbob.models.gradient import Number


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Compile `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    from plumbob.engines.adapters.mujoco.simulation import compiled

    return compiled(case, method, step)


def model_error(case: Case, method: Method, step: float) -> ModelError:
    """Bounds on the model's error of each observable, by reason; raises Unsupported."""
    from plumbob.engines.adapters.mujoco.translation import builder

    return builder(case.system).model_error(case.problem, case.scene.duration, method, step)


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on this case. With a lone free body that moves and turns, implicitfast
    takes velocity derivatives of centripetal forces into its step, as implicit does: of first order
    too, and covered by no theory here. A body of three axes that turns freely has schemes of its
    own."""
    if case.system.name == "free-body":
        from plumbob.engines.adapters.mujoco.free_body import scheme as of_a_free_body

        return of_a_free_body(method)
    implicit = str(method.settings.get("integrator")).lower() == "implicitfast"
    lone = case.system.name == "capsule-coast" and case.problem.motion.kind == "plane"
    return Scheme("implicitfast on a free body") if implicit and lone else method.scheme


def contact_model(case: Case, method: Method, step: float) -> SoftContact | None:
    """The record of the contacts at `step` [s] that theory takes; None where there are none, or no
    theory covers them. Works without MuJoCo."""
    from plumbob.engines.adapters.mujoco.contacts import soft_contact

    if not isinstance(case.problem, CapsuleProblem):
        return None
    return soft_contact(case.problem, method.settings, step)


def user_method(path: Path) -> Method:
    """The method whose settings are those of the model file `path`; raises ParameterError."""
    from plumbob.engines.adapters.mujoco import user_file

    return user_file.user_method(path)


def measure_trimming(case: Case, method: Method, step: float, steps: int, repeats: int) -> Trimming:
    """Time saved by leaving out needless stages and visual parts; raises Unsupported."""
    from plumbob.engines.adapters.mujoco.trimming import trimming

    return trimming(case, method, step, steps, repeats)


def settings_text(
    method: Method, step: float, stiffness: float | None, friction: float
) -> Settings:
    """Settings to paste for `method` at `step` [s]; raises ParameterError. Works without MuJoCo."""
    from plumbob.engines.adapters.mujoco.settings_to_paste import settings

    return settings(method, step, stiffness, friction)


def check_file(path: Path, method: Method) -> FileCheck:
    """The model file `path` compared with the settings of `method`; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.file_check import check

    return check(path, method)


def model_text(text: str, step: float) -> str:
    """A model file's text with its contacts for `step` [s]. Works without MuJoCo."""
    from plumbob.engines.adapters.mujoco.settings_to_paste import rewritten

    return rewritten(text, step)


def model_of_own(model: Any, start: Start = AS_IT_STANDS) -> OwnModel:
    """A user's model, from a file, compiled or with its data, as an audit needs it; raises
    ParameterError and NotCertifiable."""
    from plumbob.engines.adapters.mujoco.options import needless_stages
    from plumbob.engines.adapters.mujoco.own_model.model import own_model

    user_model = own_model(*_compiled(model), _start_of(model, start))
    return replace(user_model, idle=needless_stages(user_model.effective))


def _start_of(model: Any, start: Start) -> Start:
    """The start, with the state of a user's mjData where the model is given by one."""
    import mujoco

    if not isinstance(model, mujoco.MjData):
        return start
    of_data = {name: tuple(map(float, getattr(model, name))) for name in ("qpos", "qvel")}
    given = {name: state for name in of_data if (state := getattr(start, name)) is not None}
    return replace(start, **{**of_data, **given})


def _compiled(model: Any) -> tuple[Any, str]:
    """A user's model, a path or one that is compiled, and what it is called; raises
    ParameterError."""
    import mujoco

    from plumbob.engines.adapters.mujoco.user_file import compiled_model

    if isinstance(model, (str, Path)):
        return compiled_model(Path(model), "model"), str(model)
    if isinstance(model, mujoco.MjData):
        return model.model, "model"
    if isinstance(model, mujoco.MjSpec):
        try:
            return model.copy().compile(), "model"
        except ValueError as error:
            reason = " ".join(str(error).split())
            raise ParameterError("model", "MjSpec", f"one that compiles ({reason})") from None
    if not isinstance(model, mujoco.MjModel):
        what = (
            "a path to a MuJoCo model file, a mujoco.MjModel, a mujoco.MjSpec, or a mujoco.MjData, "
            "which is the start too"
        )
        raise ParameterError("model", type(model).__name__, what)
    return model, "model"


def contacts_of_own(
    model: Any, start: Start, body: str | None, friction: float | None
) -> ContactModel:
    """A free body of a user's model, from a file or compiled, on its plane; raises ParameterError
    and NotCertifiable."""
    from plumbob.engines.adapters.mujoco.user_contacts import own_contacts

    return own_contacts(*_compiled(model), _start_of(model, start), body, friction)


def controls_of_policy(
    model: Any, start: Start, policy: Policy, period: float, duration: float
) -> Array:
    """The controls of a policy while a user's model runs at its own step, shape (periods,
    actuators); raises ParameterError."""
    from plumbob.engines.adapters.mujoco.own_model.policy import recorded

    return recorded(_compiled(model)[0], _start_of(model, start), policy, period, duration)


def write_trimmed(source: Path, left_out: Sequence[Change], target: Path) -> tuple[Change, ...]:
    """Write the text of the model file `source` with these left out to `target`; returns those that
    its text can omit. Raises ParameterError."""
    from plumbob.engines.adapters.mujoco.own_model.file_text import write

    return write(source, left_out, target)


def model_fields(path: Path) -> ModelFields:
    """The numbers of a model file; raises ParameterError."""
    from plumbob.engines.adapters.mujoco.model_fields import model_fields as read

    return read(path)


def by_transitions(number: Number, method: Method, step: float) -> Mapping[str, float]:
    """Derivatives by `mjd_transitionFD`, multiplied along a run; raises Unsupported."""
    from plumbob.engines.adapters.mujoco.transition import transition as multiplied

    return multiplied(number, method, step)


ENGINE = Engine(
    "mujoco",
    "mujoco",
    METHODS,
    prepare,
    model_error,
    abilities=(
        SchemeOfCase(scheme),
        ContactRecord(contact_model),
        UserSettings(user_method),
        Ablation(measure_trimming),
        SettingsToPaste(settings_text),
        FileChecks(check_file),
        StepsOfFiles(model_text),
        ModelReader(model_fields),
        OwnDerivative("transition", by_transitions, precision=1e-8),
        UserModels(model_of_own, contacts_of_own, controls_of_policy, write_trimmed),
    ),
)
