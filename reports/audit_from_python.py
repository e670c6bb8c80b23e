"""The audit of a user model from Python: of a file, of a compiled model, or of an environment."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, counting, positive
from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import Audit, audited, with_gradient
from plumbob.engines.audit.contacts import SPEED, contacts_audited
from plumbob.engines.audit.controls import DURATION, script
from plumbob.engines.audit.engines import with_engines
from plumbob.engines.audit.environments import rollout, start_and_period
from plumbob.engines.audit.user_models import quiet, user_models
from plumbob.engines.own_motion import NotCertifiable, OwnModel, Policy, Script, Start
from plumbob.engines.registry import find_engine
from plumbob.engines.workers import Workers
from plumbob.reports.view.audit.results import ContactResult, MotionResult

BUDGET = 60.0  # [s] default processor time of an audit
FEWEST = 10  # least evaluations of a model for any answer
BRIEF = 0.05  # [s] processor time of an evaluation that every budget allows
BESIDE = 1e-9  # [m, rad, ...] distance from the start of the evaluation that is timed
RECORDED = "policy, recorded at the model's own step"


@quiet()
def audit(
    model: Any,
    control: str | Array = "rest",
    *,
    keyframe: int | str | None = None,
    qpos: Sequence[float] | None = None,
    qvel: Sequence[float] | None = None,
    duration: float | None = None,
    period: float | None = None,
    budget: float = BUDGET,
    jobs: int = 1,
    progress: Callable[[str], None] = lambda what: None,
    gradient: bool = False,
    policy: Policy | None = None,
    engines: Sequence[str] = (),
    begun: Callable[[Audit], None] = lambda audit: None,
) -> MotionResult:
    """Audits a model: how wrong are its steps, with its own integrator and step? The audit
    certifies the continuous motion of the model, and compares the model's steps with it.

    `model` is a path to an MJCF file, a `mujoco.MjModel`, an `MjSpec`, an `MjData` whose positions
    and velocities are the start, or a MuJoCo environment of Gymnasium that has been reset. The
    motion starts from a `keyframe`, or from the model's state. `qpos` and `qvel`, if given, replace
    the positions and velocities.

    `control` is "rest", "zero", "sines" or values of shape (periods, actuators), each held for
    `period` [s]. The motion lasts `duration` [s]. The audit takes about `budget` [s] of processor
    time. With several `jobs` the integrators run in as many processes; costs are measured alone.

    A `policy` replaces `control`. It is called with time, qpos and qvel at the beginning of each
    period (default: one step) of a run at the model's own step. The reference and all other steps
    replay the controls that it gave. If the model is an environment, its policy is called with its
    observations, and the environment is stepped. A control is then held as long as the environment
    holds an action.

    If `gradient` is set, derivatives of the final state with respect to controls and start are
    certified too, in as much time again. Each of `engines`, by name, runs the file too, each in as
    much time. `begun` is called with the audit before anything is computed. Raises ParameterError
    for bad input, and for a model for which no reference can be certified.

    >>> import mujoco
    >>> rod = '''<mujoco><worldbody><body><joint axis="0 1 0"/>
    ...   <geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>'''
    >>> found = audit(mujoco.MjModel.from_xml_string(rod), duration=0.1, budget=5.0)
    >>> found.until, found.resolved, found.assert_within(metres=0.01)
    (0.1, True, None)
    """
    positive("budget", budget)
    counting("jobs", jobs)
    engines = engines.split(",") if isinstance(engines, str) else engines
    _known(engines, model)
    start = Start(keyframe, qpos, qvel)
    named = RECORDED if policy is not None else control if isinstance(control, str) else "given"
    if hasattr(getattr(model, "unwrapped", None), "frame_skip"):
        environment = model
        model, period = start_and_period(environment)
        if policy is not None:
            control, policy = rollout(environment, policy, _lasting(duration)), None
            duration = None
    user_model, moved = user_motion(model, start, control, policy, duration, period, budget)
    with Workers(jobs) as workers:
        beside = Allowance(budget, executor=workers if jobs > 1 else None, progress=progress)
        answer = audited(user_model, moved, named, beside, begun)
    if gradient:
        answer = with_gradient(answer, Allowance(budget, progress=progress))
    return MotionResult(**vars(with_engines(answer, model, engines, budget, progress)))


def _known(engines: Sequence[str], model: Any) -> None:
    """Raises ParameterError for unknown engines, and for engines that have no file to read."""
    for name in engines:
        find_engine(name)
    if engines and not (isinstance(model, (str, Path)) and Path(model).suffix == ".xml"):
        raise ParameterError("engines", ",".join(engines), "left out, but with an MJCF file")


def user_motion(
    model: Any,
    start: Start,
    control: str | Array = "rest",
    policy: Policy | None = None,
    duration: float | None = None,
    period: float | None = None,
    budget: float = BUDGET,
) -> tuple[OwnModel, Script]:
    """Returns a user's model, and its motion: start, controls and duration. A policy's motion is
    recorded. Raises ParameterError for a model that has no continuous motion, and if the budget [s]
    is too small."""
    name = str(model) if isinstance(model, (str, Path)) else "model"
    try:
        user_model = user_models().model(model, start)
        if policy is not None:
            held = user_model.step if period is None else positive("ctrl period", period)
            control = user_model.recorded(policy, held, _lasting(duration))
            period, duration = held, None
        moved = script(user_model, control, duration, period)
    except NotCertifiable as why:
        raise ParameterError(
            "model", name, f"one that has a continuous motion; {why}"
        ) from None
    _affordable(user_model, moved, budget)
    return user_model, moved


def _affordable(user_model: OwnModel, moved: Script, budget: float) -> None:
    """Raises ParameterError if FEWEST evaluations of the model take more than the budget [s]: every
    reference needs as many. The check comes first, since an evaluation cannot be ended once it has
    begun. One evaluation is timed at a state beside the start. At the start itself, the constraint
    solver may need no iteration."""
    field = user_model.field()
    field.hold(moved.controls[0], 0.0, moved.start)
    beside = moved.start + np.resize((BESIDE, -BESIDE), moved.start.shape)
    begin = time.process_time()
    # If the model fails here, the reference reports the reason later.
    with suppress(NotCertifiable), np.errstate(all="ignore"):
        field(0.0, beside)
    spent = time.process_time() - begin
    if spent > max(budget / FEWEST, BRIEF):
        what = f"{FEWEST * spent:.2g} or more: one evaluation of the model takes {spent:.2g} s"
        raise ParameterError("budget", budget, what)


def _lasting(duration: float | None) -> float:
    """Returns the duration [s], or the default one; raises ParameterError if it is not positive."""
    return DURATION if duration is None else positive("duration", duration)


@quiet()
def audit_contacts(
    model: Any,
    *,
    speed: float = SPEED,
    body: str | None = None,
    friction: float | None = None,
    keyframe: int | str | None = None,
) -> ContactResult:
    """Audits the contacts of a free body on its plane: how far it slides from `speed` [m/s], drifts
    under a push, and depends on direction. The model's own friction settings and those that
    `plumbob settings` recommends are compared with Coulomb's answer.

    `model` is a path to an MJCF file or a compiled `mujoco.MjModel`. `body` names the body; without
    a name it is the heaviest free body. Joints are locked in the posture of the start. `friction`
    replaces the coefficients of the model. Raises ParameterError for bad input, and for a model
    that has no such body, with the reason.

    >>> import mujoco
    >>> box = '''<mujoco><worldbody><geom name="floor" type="plane" size="9 9 1"/>
    ...   <body name="box" pos="0 0 .1"><freejoint/><geom type="box" size=".1 .2 .02"/></body>
    ...   </worldbody></mujoco>'''
    >>> found = audit_contacts(mujoco.MjModel.from_xml_string(box))
    >>> round(found.exact, 6), bool(found.error(found.own[0]) > found.error(found.pasted[0]))
    (0.012742, True)
    """
    positive("speed", speed)
    if friction is not None:
        positive("friction", friction)
    name = str(model) if isinstance(model, (str, Path)) else "model"
    try:
        start = Start(keyframe)
        standing = user_models().contacts(model, start, body, friction)
        return ContactResult(**vars(contacts_audited(standing, speed)))
    except NotCertifiable as why:
        what = f"one whose contacts can be audited; {why}"
        raise ParameterError("model", name, what) from None
