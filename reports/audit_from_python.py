"""The audit of a user model from Python: of a file, of a compiled model, or of an environment."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, counting, positive
from plumbob.analytic.reference import Array
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import Audit, audited, with_gradient, with_returns
from plumbob.engines.audit.contacts import SPEED, contacts_audited
from plumbob.engines.audit.controls import DURATION, script
from plumbob.engines.audit.engines import with_engines
from plumbob.engines.audit.environments import rollout, start_and_period
from plumbob.engines.audit.episodes import EpisodePlan
from plumbob.engines.audit.user_models import quiet, user_models
from plumbob.engines.closed_loop import ClosedLoop, NamedPolicy, new_policy
from plumbob.engines.own_motion import (
    NotCertifiable,
    NotControlled,
    OwnModel,
    Policy,
    Script,
    Start,
)
from plumbob.engines.registry import find_engine
from plumbob.engines.workers import Workers
from plumbob.reports.view.audit.results import ContactResult, MotionResult

AUDIT_SECONDS = 60.0  # [s] default processor time of an audit
LEAST_EVALUATIONS = 10  # least evaluations of a model for any answer
ALLOWED_SECONDS = 0.05  # [s] processor time of an evaluation that every budget allows
START_OFFSET = 1e-9  # [m, rad, ...] distance from the start of the evaluation that is timed
RECORDED_POLICY = "policy, recorded at the model's own step"
ASKED_POLICY = "policy, in the loop of each run"


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
    budget: float = AUDIT_SECONDS,
    jobs: int = 1,
    progress: Callable[[str], None] = lambda what: None,
    gradient: bool = False,
    policy: Policy | NamedPolicy | None = None,
    in_the_loop: bool = False,
    engines: Sequence[str] = (),
    episodes: EpisodePlan | None = None,
    begun: Callable[[Audit], None] = lambda audit: None,
    references: Path | None = None,
) -> MotionResult:
    """Audits a model: how wrong are its own steps beside its certified continuous motion?

    `model` is a path to an MJCF file, a `mujoco.MjModel`, an `MjSpec`, an `MjData` (its state is
    the start), or a MuJoCo environment of Gymnasium that has been reset. The motion starts from a
    `keyframe`, or from the model's state; `qpos` and `qvel` replace positions and velocities. It
    lasts `duration` [s]. `control` is "rest", "zero", "sines" or values of shape (periods,
    actuators), each held for `period` [s]. A `policy` replaces it: a function of time, qpos and
    qvel, or an environment's observation, called at the begin of each period (default: one step,
    or as long as the environment holds an action) of a run at the model's own step. All runs
    replay its controls, or, if it is `in_the_loop`, ask it with their own states.

    It takes about `budget` [s] of processor time, with the integrators in `jobs` processes, and as
    much again for each of derivatives (`gradient`), other `engines`, and `episodes`. `begun` is
    called with the audit before anything is computed. The folder `references` keeps the certified
    motion for the next audit of it. Raises ParameterError, also if no reference can be certified.

    >>> import mujoco
    >>> rod = '''<mujoco><worldbody><body><joint axis="0 1 0"/>
    ...   <geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>'''
    >>> found = audit(mujoco.MjModel.from_xml_string(rod), duration=0.1, budget=5.0)
    >>> found.until, found.resolved, found.assert_within(metres=0.01)
    (0.1, True, None)
    """
    _check_effort(budget, jobs)
    engines = _checked_engines(engines, model)
    control_name = _control_name(control, policy, in_the_loop)
    if hasattr(getattr(model, "unwrapped", None), "frame_skip"):
        model, control, duration, period = _environment_motion(model, control, policy, duration)
        policy = None
    _check_loop(in_the_loop, policy, engines)
    given = (control, policy, duration, period, budget, in_the_loop)
    user_model, motion = user_motion(model, Start(keyframe, qpos, qvel), *given)
    with Workers(jobs) as workers:
        # Another process can only load a policy that has a name.
        shared = jobs > 1 and (not in_the_loop or isinstance(policy, NamedPolicy))
        allowance = Allowance(budget, workers if shared else None, progress)
        result = audited(user_model, motion, control_name, allowance, begun, references)
    allowance = Allowance(budget, progress=progress)
    result = _with_further_answers(result, motion, gradient, episodes, allowance)
    return MotionResult(**vars(with_engines(result, model, engines, budget, progress)))


def _with_further_answers(
    result: Audit,
    motion: Script,
    gradient: bool,
    episodes: EpisodePlan | None,
    allowance: Allowance,
) -> Audit:
    """Returns an audit of a motion with derivatives and with returns of episodes, if the user asks
    for them. Each takes as much time as is allowed. Raises ParameterError."""
    if gradient:
        result = with_gradient(result, allowance.part(1.0))
    if episodes is not None:
        result = with_returns(result, motion, episodes, allowance.part(1.0))
    return result


def _check_loop(
    in_the_loop: bool, policy: Policy | NamedPolicy | None, engines: Sequence[str]
) -> None:
    """Raises ParameterError if an audit in the loop has no policy of a model's states, or asks for
    engines with a policy that their processes cannot load."""
    if in_the_loop and policy is None:
        wanted = "given with a policy, and left out with an environment"
        raise ParameterError("in the loop", in_the_loop, wanted)
    if in_the_loop and engines and not isinstance(policy, NamedPolicy):
        raise ParameterError("engines", ",".join(engines), "left out, or with a NamedPolicy")


def _environment_motion(
    environment: Any,
    control: str | Array,
    policy: Policy | NamedPolicy | None,
    duration: float | None,
) -> tuple[Any, str | Array, float | None, float]:
    """Returns an environment's model, and the controls, the duration [s] and the control period [s]
    of its motion. If there is a policy, its rollout gives the controls and the duration."""
    model, period = start_and_period(environment)
    if policy is not None:
        control = rollout(environment, new_policy(policy), _duration_or_default(duration))
        duration = None
    return model, control, duration, period


def _control_name(
    control: str | Array, policy: Policy | NamedPolicy | None, in_the_loop: bool
) -> str:
    """Returns the name of the controls in the audit: a policy's, a named control's, or `given`."""
    if policy is not None:
        return ASKED_POLICY if in_the_loop else RECORDED_POLICY
    return control if isinstance(control, str) else "given"


def _check_effort(budget: float, jobs: int) -> None:
    """Raises ParameterError unless the budget [s] and the number of processes are positive."""
    positive("budget", budget)
    counting("jobs", jobs)


def _checked_engines(engines: str | Sequence[str], model: Any) -> Sequence[str]:
    """Returns the names of engines, which may be a text with commas. Raises ParameterError for
    unknown engines, and for engines without an MJCF file to read."""
    names = engines.split(",") if isinstance(engines, str) else engines
    for name in names:
        find_engine(name)
    is_file = isinstance(model, (str, Path)) and Path(model).suffix == ".xml"
    if names and not is_file:
        raise ParameterError("engines", ",".join(names), "left out, but with an MJCF file")
    return names


def user_motion(
    model: Any,
    start: Start,
    control: str | Array = "rest",
    policy: Policy | NamedPolicy | None = None,
    duration: float | None = None,
    period: float | None = None,
    budget: float = AUDIT_SECONDS,
    in_the_loop: bool = False,
) -> tuple[OwnModel, Script]:
    """Returns a user's model, and its motion: start, controls and duration. A policy's motion is
    recorded; if it is `in_the_loop`, each run asks the policy. Raises ParameterError for a model
    that has no continuous motion, and if the budget [s] is too small."""
    try:
        user_model = user_models().model(model, start)
        loop = None
        if policy is not None:
            velocities = user_model.layout.velocity
            loop = ClosedLoop(policy, user_model.rest.size, velocities)
            held = user_model.step if period is None else positive("ctrl period", period)
            control = _recorded(user_model, loop, held, _duration_or_default(duration))
            period, duration = held, None
        motion = script(user_model, control, duration, period)
        if in_the_loop:
            motion = replace(motion, loop=loop)
    except NotCertifiable as reason:
        wanted = f"one that has a continuous motion; {reason}"
        raise ParameterError("model", _model_name(model), wanted) from None
    _check_budget(user_model, motion, budget)
    return user_model, motion


def _recorded(model: OwnModel, loop: ClosedLoop, period: float, duration: float) -> Array:
    """Returns the controls that a policy gives to a run at the model's own step, shape (periods,
    actuators). Raises ParameterError."""
    try:
        return model.recorded(loop, period, duration)
    except NotControlled as why:
        wanted = f"one that returns finite numbers; {why}"
        raise ParameterError("policy", loop.name, wanted) from None


def _model_name(model: Any) -> str:
    """Returns the name of a model in a message: its path, or "model"."""
    return str(model) if isinstance(model, (str, Path)) else "model"


def _check_budget(model: OwnModel, motion: Script, budget: float) -> None:
    """Raises ParameterError if LEAST_EVALUATIONS of the model take more than the budget [s]: every
    reference needs as many. The check comes first, since an evaluation cannot be ended once it has
    begun. One evaluation is timed at a state beside the start. At the start itself, the constraint
    solver may need no iteration."""
    field = model.field()
    field.hold(motion.controls[0], 0.0, motion.start)
    beside_start = motion.start + np.resize((START_OFFSET, -START_OFFSET), motion.start.shape)
    begin = time.process_time()
    # If the model fails here, the reference reports the reason later.
    with suppress(NotCertifiable), np.errstate(all="ignore"):
        field(0.0, beside_start)
    seconds = time.process_time() - begin
    if seconds > max(budget / LEAST_EVALUATIONS, ALLOWED_SECONDS):
        least = f"{LEAST_EVALUATIONS * seconds:.2g} or more"
        reason = f"one evaluation of the model takes {seconds:.2g} s"
        raise ParameterError("budget", budget, f"{least}: {reason}")


def _duration_or_default(duration: float | None) -> float:
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
    try:
        standing = user_models().contacts(model, Start(keyframe), body, friction)
        return ContactResult(**vars(contacts_audited(standing, speed)))
    except NotCertifiable as reason:
        wanted = f"one whose contacts can be audited; {reason}"
        raise ParameterError("model", _model_name(model), wanted) from None
