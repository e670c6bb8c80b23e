"""The audit of a user model from Python: of a file, of a compiled model, or of an environment."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plumbob.analytic.parameters import ParameterError, counting, positive
from plumbob.analytic.reference import Array
from plumbob.engines.abilities import RunsCopies
from plumbob.engines.audit.allowance import Allowance
from plumbob.engines.audit.audit import Audit, audited, with_gradient, with_returns
from plumbob.engines.audit.contacts import SPEED, contacts_audited
from plumbob.engines.audit.controls import held_period, possible_duration, script
from plumbob.engines.audit.engines import with_engines
from plumbob.engines.audit.environment_returns import EnvironmentEpisodes, motion_return
from plumbob.engines.audit.environments import (
    AskedEnvironment,
    observed,
    rollout,
    start_and_period,
)
from plumbob.engines.audit.episodes import EpisodePlan, Episodes, ModelEpisodes
from plumbob.engines.audit.holds import CREEP_WANTED, holds_audited
from plumbob.engines.audit.user_models import certifiable_model, quiet, user_models
from plumbob.engines.closed_loop import (
    OF_OBSERVATION,
    ClosedLoop,
    NamedPolicy,
    PolicyAnswers,
    name_of_function,
)
from plumbob.engines.difference.port_repetitions import ports, repeated_motion
from plumbob.engines.own_motion import (
    NotCertifiable,
    NotControlled,
    OwnModel,
    Policy,
    Script,
    Start,
    periods,
)
from plumbob.engines.registry import find_engine
from plumbob.engines.workers import Workers
from plumbob.reports.advice.creep_options import creep_options
from plumbob.reports.view.audit.results import (
    ContactResult,
    HoldsResult,
    MotionResult,
    RepeatedResult,
)

AUDIT_SECONDS = 60.0  # [s] default processor time of an audit
LEAST_EVALUATIONS = 10  # least evaluations of a model for any answer
ALLOWED_SECONDS = 0.05  # [s] processor time of an evaluation that every budget allows
START_OFFSET = 1e-9  # [m, rad, ...] distance from the start of the evaluation that is timed
EPISODES_MODULE = "plumbob.engines.audit.environment_returns"
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
    actuators), each held for `period` [s] (default: one step, or as long as an environment holds an
    action). A `policy` replaces it: a function of time, qpos and qvel, or of an environment's
    observation. A run at the model's own step asks it at the begin of each period, and all runs
    replay its controls; if it is `in_the_loop`, all runs ask it with their own states.

    It takes about `budget` [s] of processor time in `jobs` processes, and as much again for each of
    derivatives (`gradient`), other `engines`, and `episodes`. `begun` is called with the audit
    before anything is computed. A folder `references` keeps certified motions for later audits.
    Raises ParameterError for bad input, and if no reference can be certified.

    >>> import mujoco
    >>> rod = '''<mujoco><worldbody><body><joint axis="0 1 0"/>
    ...   <geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>'''
    >>> found = audit(mujoco.MjModel.from_xml_string(rod), duration=0.1, budget=5.0)
    >>> found.until, found.resolved, found.assert_within(metres=0.01)
    (0.1, True, None)
    """
    _check_effort(budget, jobs)
    engines = _checked_engines(engines, model)
    environment = model if hasattr(getattr(model, "unwrapped", None), "frame_skip") else None
    _check_loop(in_the_loop, policy, engines)
    _check_episodes(episodes, in_the_loop, environment)
    asked = _AskedFor(gradient, policy, in_the_loop, environment, episodes)
    name = _control_name(control, policy, in_the_loop)
    if environment is not None:
        model, control, duration, period = asked.environment_motion(control, duration)
    given = (control, asked.motion_policy, duration, period, budget, in_the_loop, environment)
    user_model, motion = user_motion(model, Start(keyframe, qpos, qvel), *given)
    with Workers(jobs) as workers:
        allowance = Allowance(budget, asked.executor(workers), progress)
        result = audited(user_model, motion, name, allowance, begun, references)
        result = asked.further_answers(result, motion, Allowance(budget, workers, progress))
    return MotionResult(**vars(with_engines(result, model, engines, budget, progress)))


@dataclass(frozen=True)
class _AskedFor:
    """The answers that a user asks for, and the policy that controls the motion."""

    gradient: bool
    policy: Policy | NamedPolicy | None
    in_the_loop: bool
    environment: Any  # None: the motion is a model's
    plan: EpisodePlan | None

    @property
    def motion_policy(self) -> Policy | NamedPolicy | None:
        """The policy that runs of the model ask or record; None if the environment's own rollout
        records its controls."""
        return self.policy if self.in_the_loop or self.environment is None else None

    def environment_motion(
        self, control: str | Array, duration: float | None
    ) -> tuple[Any, str | Array, float | None, float]:
        """Returns the environment's model, and the controls, the duration [s] and the control
        period [s] of its motion. If controls are replayed, its rollout under the policy gives the
        controls and the duration. Raises ParameterError."""
        model, period = start_and_period(self.environment)
        if self.policy is not None and not self.in_the_loop:
            seconds = possible_duration(duration, period)
            control, duration = _rolled_out(self.environment, self.policy, seconds), None
        return model, control, duration, period

    def executor(self, workers: Workers) -> Workers | None:
        """Returns the processes for the audit itself; None if there is one alone, or if others
        cannot load the policy. They import meanwhile what episodes need."""
        if workers.count == 1:
            return None
        if self.plan is not None:
            workers.begin(workers.count, EPISODES_MODULE)
        named = isinstance(self.policy, NamedPolicy) and self.environment is None
        return workers if named or not self.in_the_loop else None

    def further_answers(self, result: Audit, motion: Script, allowance: Allowance) -> Audit:
        """Returns an audit of a motion with derivatives, the return of an environment, and returns
        of episodes, as far as they are asked for. Derivatives and episodes take as much time as is
        allowed, each. Raises ParameterError."""
        if self.gradient:
            alone = Allowance(allowance.seconds, progress=allowance.progress)
            result = with_gradient(result, alone)
        if self.environment is not None and self.policy is not None and self.in_the_loop:
            about = (self.environment, self.policy, result.model, motion, result.reference)
            result = replace(result, motion_return=motion_return(*about))
        if self.plan is not None:
            episodes = _episodes(result.model, motion, self.policy, self.environment, self.plan)
            result = with_returns(result, episodes, self.plan, allowance.part(1.0))
        return result


def _episodes(
    model: OwnModel,
    motion: Script,
    policy: Policy | NamedPolicy | None,
    environment: Any,
    plan: EpisodePlan,
) -> Episodes:
    """Returns the episodes of a plan: of an environment under a policy, or of a model whose script
    asks the policy, if there is one."""
    if environment is None or policy is None:
        assert plan.metric is not None
        return ModelEpisodes(model, motion, plan.metric, plan.spread)
    seed = max(0, environment.unwrapped.np_random_seed)
    return EnvironmentEpisodes(environment.spec or environment, seed, policy, model, motion)


def _check_episodes(plan: EpisodePlan | None, in_the_loop: bool, environment: Any) -> None:
    """Raises ParameterError unless episodes of a model have a metric, and those of an environment a
    policy in the loop and no metric."""
    if plan is None:
        return
    if environment is None and plan.metric is None:
        raise ParameterError("episodes", plan.count, "given with a metric")
    if environment is not None and plan.metric is not None:
        name = name_of_function(plan.metric)
        raise ParameterError("metric", name, "left out with an environment, which has rewards")
    if environment is not None and not in_the_loop:
        wanted = "given with a policy in the loop, with an environment"
        raise ParameterError("episodes", plan.count, wanted)


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


def _rolled_out(environment: Any, policy: Policy | NamedPolicy, duration: float) -> Array:
    """Returns the controls of an environment's rollout under a policy, shape (periods, actuators),
    for a duration [s] or to the end of the episode. Raises ParameterError."""
    answers = PolicyAnswers(policy, OF_OBSERVATION)
    count = periods(duration, environment.unwrapped.dt)
    try:
        return rollout(environment, observed(environment), answers, count).controls
    except NotControlled as why:
        raise ParameterError("policy", answers.name, f"{OF_OBSERVATION}; {why}") from None


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
    environment: Any = None,
) -> tuple[OwnModel, Script]:
    """Returns a user's model, and its motion: start, controls and duration. A policy's motion is
    recorded; if it is `in_the_loop`, each run asks the policy, which an `environment` of the model
    gives its observations. Raises ParameterError for a model that has no continuous motion, and if
    the budget [s] is too small."""
    with certifiable_model(model, "one that has a continuous motion"):
        user_model = user_models().model(model, start)
        loop = None
        if policy is not None:
            velocities = user_model.layout.velocity
            ask = None
            if environment is not None:
                ask = AskedEnvironment(environment, user_model)
            loop = ClosedLoop(policy, user_model.rest.size, velocities, ask)
            held = held_period(user_model, user_model.step if period is None else period)
            control = _recorded(user_model, loop, held, possible_duration(duration, held))
            period, duration = held, None
        motion = script(user_model, control, duration, period)
        if in_the_loop:
            motion = replace(motion, loop=loop)
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


@quiet()
def audit_reproducible(
    model: Any,
    control: str | Array = "rest",
    *,
    keyframe: int | str | None = None,
    qpos: Sequence[float] | None = None,
    qvel: Sequence[float] | None = None,
    duration: float | None = None,
    period: float | None = None,
    budget: float = AUDIT_SECONDS,
    progress: Callable[[str], None] = lambda what: None,
    policy: Policy | NamedPolicy | None = None,
    engines: Sequence[str] = (),
) -> RepeatedResult:
    """Computes the motion of a model's own steps again in other ways, in which its bits, or all but
    rounding and the solver's tolerance, should be the same: once more, on several threads, with
    another Jacobian, other solvers and flags, and in ports of MuJoCo named in `engines`.

    Arguments are those of `audit`; each engine takes about as much time again, and time to compile.
    Raises ParameterError.

    >>> import mujoco
    >>> rod = '''<mujoco><worldbody><body><joint axis="0 1 0"/>
    ...   <geom size=".1" pos=".5 0 0"/></body></worldbody></mujoco>'''
    >>> found = audit_reproducible(mujoco.MjModel.from_xml_string(rod), duration=0.1)
    >>> found.repetitions[0].verdict, found.assert_reproducible()
    ('same bits', None)
    """
    _check_effort(budget, 1)
    for name in engines:
        if find_engine(name).ability(RunsCopies) is None:
            raise ParameterError("engines", name, f"of {', '.join(ports())}")
    given = (control, policy, duration, period, budget)
    user_model, motion = user_motion(model, Start(keyframe, qpos, qvel), *given)
    control_name = _control_name(control, policy, False)
    with certifiable_model(model, "one whose motion can be repeated"):
        allowance = Allowance(budget, progress=progress)
        result = repeated_motion(user_model, motion, control_name, allowance, engines)
    return RepeatedResult(**vars(result))


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
    with certifiable_model(model, "one whose contacts can be audited"):
        standing = user_models().contacts(model, Start(keyframe), body, friction)
        return ContactResult(**vars(contacts_audited(standing, speed)))


@quiet()
def audit_holds(
    model: Any,
    *,
    body: str | None = None,
    keyframe: int | str | None = None,
    qpos: Sequence[float] | None = None,
    creep_within: float = CREEP_WANTED,
) -> HoldsResult:
    """Audits whether bodies hold at rest: what Coulomb's law says, how fast the engine lets them
    creep, and which options bring the creep to `creep_within` [m/s].

    `model` is a path to an MJCF file or a compiled `mujoco.MjModel`. `body` is one body that can
    move; without a name all bodies count that touch something. They are judged at the start, under
    its controls; if nothing balances there, as before servos have given way, where they settle.
    Raises ParameterError for bad input, and if nothing touches.

    >>> import mujoco
    >>> ramp = '''<mujoco><worldbody><geom type="plane" size="9 9 1" euler="0 15 0"/>
    ...   <body pos="0.013 0 0.0483" euler="0 15 0"><freejoint/>
    ...   <geom type="box" size=".1 .1 .05"/></body></worldbody></mujoco>'''
    >>> found = audit_holds(mujoco.MjModel.from_xml_string(ramp))
    >>> found.coulomb, round(found.worst.statics.least_friction, 3)
    ('holds', 0.268)
    """
    positive("creep within", creep_within)
    with certifiable_model(model, "one whose bodies rest on contacts"):
        held = user_models().held(model, Start(keyframe, qpos), body)
        return HoldsResult(**vars(holds_audited(held, creep_within, creep_options)))
