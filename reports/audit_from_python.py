"""The audit of a user model from Python: a path, or a compiled model and its controls."""

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

BUDGET = 60.0  # [s] of processor time
FEWEST = 10  # evaluations of a model for any answer
BRIEF = 0.05  # [s] of processor time: an evaluation that the audit of any budget has time for
BESIDE = 1e-9  # [m, rad, ...] by which that evaluation is beside the start
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
    """How wrong `model`, a path to an MJCF file, a `mujoco.MjModel`, an `MjSpec`, an `MjData`,
    whose positions and velocities are the start, or a MuJoCo environment of Gymnasium that has been
    reset, is at its own integrator and step: its continuous motion is certified, and its steps are
    held against it. It starts from a `keyframe`, or as it stands, with `qpos` and `qvel` in place
    of those, if given.

    `control` is "rest", "zero", "sines" or values of shape (periods, actuators), held for `period`
    [s]; the motion lasts `duration` [s]; the whole takes about `budget` [s] of processor time. With
    more `jobs` integrators run in as many processes; costs are measured alone. A `policy`, called
    with time, qpos and qvel at the beginning of each period, by default of one step, takes the
    control's place: what it gives at the model's own step is replayed by the reference and all
    steps. That of an environment is called with its observations, and the environment is stepped,
    so that the rollout is its own; a control is held as it holds an action. A `gradient` certifies
    derivatives of the end by controls and start, too, in as much time again, and each of `engines`,
    by name, runs the file, in as much. `begun` gets the audit before that. Raises ParameterError
    for bad input, and for a model that no reference can be certified for.

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
    """Raises ParameterError for names of no engine, or of some without a file to read."""
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
    """A user's model, and its motion, which a policy records; raises ParameterError, also where the
    budget [s] is too small."""
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
    """Raises ParameterError if the budget [s] is less than FEWEST evaluations of a model take,
    which every reference needs. It is looked at first, since an evaluation that has begun cannot be
    ended. One evaluation is timed beside the start, and not at it, where the solver of constraints
    may need no iteration."""
    field = user_model.field()
    field.hold(moved.controls[0], 0.0, moved.start)
    beside = moved.start + np.resize((BESIDE, -BESIDE), moved.start.shape)
    begin = time.process_time()
    # If the model fails here, the reference says why, later.
    with suppress(NotCertifiable), np.errstate(all="ignore"):
        field(0.0, beside)
    spent = time.process_time() - begin
    if spent > max(budget / FEWEST, BRIEF):
        what = f"{FEWEST * spent:.2g} or more: one evaluation of the model takes {spent:.2g} s"
        raise ParameterError("budget", budget, what)


def _lasting(duration: float | None) -> float:
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
    """How far the free body `body` of `model` (the heaviest) slides on its plane from `speed`
    [m/s], drifts under a push and depends on direction, with the model's own friction settings and
    those of `plumbob settings`, beside Coulomb's answer. Joints are locked in the posture of the
    start; `friction` replaces the coefficients of the model. `model` is a path to an MJCF file or a
    compiled `mujoco.MjModel`. Raises ParameterError for bad input, and for a model that has no such
    body, with the reason.

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
