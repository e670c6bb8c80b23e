"""MuJoCo as an engine: its methods and abilities.

MuJoCo, and the modules that need it, are imported when one of these functions is called.
"""

from __future__ import annotations

from dataclasses import replace

from plumbob.analytic.schemes import Scheme
from plumbob.engines.abilities import (
    Ablation,
    CompilesScenes,
    FileChecks,
    ModelReader,
    OwnDerivative,
    OwnFit,
    SchemeOfCase,
    SettingsToPaste,
    StepsOfFiles,
    UserModels,
    UserSettings,
)
from plumbob.engines.adapters.mujoco.methods import METHODS
from plumbob.engines.method import Engine, Method
from plumbob.engines.registry import builder, model_error
from plumbob.models.scene import FREE_ROTATION, ON_PLANE, SMOOTH, Case, later

prepare = later(f"{__name__}.simulation.compiled")


def scheme(case: Case, method: Method) -> Scheme:
    """The scheme of `method` on a case.

    - Free rotation, loops and contacts: the builder of the system names the scheme. - A servo with
    Euler: the motor's damping is explicit, the joint's implicit. - A single free body that moves
    and turns, with implicitfast: the step takes velocity derivatives of centripetal forces, as
    `implicit` does. It is of first order; no theory here covers it. - Otherwise: the method's own
    scheme."""
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


ENGINE = Engine(
    "mujoco",
    "mujoco",
    METHODS,
    prepare,
    model_error,
    abilities=(
        SchemeOfCase(scheme),
        UserSettings(later(f"{__name__}.user_file.user_method")),
        Ablation(later(f"{__name__}.trimming.trimming")),
        SettingsToPaste(later(f"{__name__}.settings_to_paste.settings")),
        CompilesScenes(
            later(f"{__name__}.scene_mechanism.scene_mechanism"),
            later(f"{__name__}.translation.translated"),
            later(f"{__name__}.own_model.scene_model.scene_model"),
        ),
        FileChecks(later(f"{__name__}.file_check.check")),
        StepsOfFiles(later(f"{__name__}.settings_to_paste.rewritten")),
        ModelReader(later(f"{__name__}.model_fields.model_fields")),
        *(
            OwnDerivative(
                way,
                later(f"{__name__}.transition.{way}"),
                beside=later(f"{__name__}.transition.{way}_beside"),
            )
            for way in ("transition", "inverse")
        ),
        OwnFit("sysid", later(f"{__name__}.sysid.fit")),
        UserModels(
            later(f"{__name__}.own_model.model.model_of_own"),
            later(f"{__name__}.own_model.user_contacts.own_contacts"),
            later(f"{__name__}.own_model.file_text.write"),
            later(f"{__name__}.options.collected"),
        ),
    ),
)
