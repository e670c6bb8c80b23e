"""Exudyn as an engine: a kinematic tree under its implicit generalised-alpha solver, which is its
default, and two of its explicit Runge-Kutta methods. The solver steps in C++ and keeps every state.
"""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np

from plumbob.analytic.schemes import RK4, Scheme
from plumbob.engines import sampling
from plumbob.engines.adapters.hinged_body import (
    PENDULUMS,
    HingedBody,
    hinged_body,
    model_error_on_platform,
)
from plumbob.engines.adapters.stepping import Followed, FollowedSimulation
from plumbob.engines.adapters.three_feet import CAPSULE
from plumbob.engines.method import Engine, Method, Options, Simulation, Unsupported
from plumbob.models.scene import Case

NO_CONTACTS = (
    "its contacts are penalties with a friction regularised over a speed, between spheres and"
    " triangles, and no joint of it has a prescribed acceleration"
)
# Of order 6, its error is at the round-off level after two or three octaves of steps: scenes that
# leave four. Elsewhere its verdict would be that nothing is claimed.
RESOLVED = ("linear-pendulum/free-large", "linear-pendulum/forced-large")
# Beside a separatrix no step of a method without theory shows to which side it goes.
AWAY_FROM_SADDLES = ("!cone-pendulum/*-barrier-*",)
METHODS = (
    Method(
        "exudyn/default",
        Scheme("generalised alpha"),
        2,
        settings={"solver": "GeneralizedAlpha"},
        systems=(*AWAY_FROM_SADDLES, "capsule-line/heading-030"),
        kinds=PENDULUMS,
    ),
    Method(
        "exudyn/alpha+tight",
        Scheme("generalised alpha"),
        2,
        settings={"solver": "GeneralizedAlpha", "relativeTolerance": 1e-13},
        systems=AWAY_FROM_SADDLES,
        kinds=PENDULUMS,
    ),
    Method("exudyn/rk44", Scheme(RK4), 4, settings={"solver": "RK44"}, kinds=PENDULUMS),
    Method(
        "exudyn/rk67",
        Scheme("runge-kutta of order 6"),
        6,
        settings={"solver": "RK67"},
        systems=RESOLVED,
    ),
)


def prepare(case: Case, method: Method, step: float) -> Simulation:
    """Assemble `case` for `method` at `step` [s]; raises Unsupported and ParameterError."""
    if case.system.family == CAPSULE:
        raise Unsupported(NO_CONTACTS)
    body = hinged_body(case)
    duration = case.scene.duration
    sampling.step_count(duration, step)
    begin = time.perf_counter()
    _assembled(body)[2].Reset()
    seconds = time.perf_counter() - begin
    follow = partial(_follow, body, method.settings, step)
    return FollowedSimulation(follow, dict, duration, seconds, body.limits)


def _follow(
    body: HingedBody, settings: Options, step: float, duration: float, samples: int
) -> Followed:
    import exudyn

    exudyn.config.printToConsole = False  # warnings of memory go there
    (system, sensors, container) = _assembled(body)
    steps = max(1, round(duration / step))
    why: tuple[str, ...] = ()
    try:
        solver = getattr(exudyn.DynamicSolverType, settings["solver"])
        chosen = _options(settings, steps, step)
        system.SolveDynamic(chosen, solverType=solver, showHints=False)
    except (RuntimeError, ValueError) as error:
        why = (" ".join(str(error).split())[:200],)
    angles, rates = (np.atleast_2d(system.GetSensorStoredData(s))[:, -1] for s in sensors)
    container.Reset()
    exudyn.config.printToConsole = True
    kept = sampling.sampled(steps, samples)
    kept = kept[kept < len(angles)]
    observed = {"theta": angles[kept], "theta_dot": rates[kept]}
    return Followed(
        np.asarray(kept * step, dtype=np.float64),
        observed,
        len(angles) - 1,
        len(angles) > steps,
        why,
    )


def _assembled(body: HingedBody) -> tuple[Any, tuple[int, int], Any]:
    """The system, its sensors of coordinates and of their rates, and their container."""
    import exudyn
    import exudyn.itemInterface

    items = exudyn.itemInterface

    container = exudyn.SystemContainer()
    system = container.AddSystem()
    links = body.links
    count = len(body.links)
    node = system.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=[0.0] * count,
            initialCoordinates=[link.position for link in links],
            initialCoordinates_t=[link.rate for link in links],
            numberOfODE2Coordinates=count,
        )
    )
    moments = [link.hold * np.eye(3) if link.hold else link.moments for link in links]
    amplitude, frequency = body.forcing or (0.0, 0.0)

    def push(mbs: Any, t: float, item: int, q: Any, q_t: Any) -> list[float]:
        return [amplitude * float(np.sin(frequency * t))]

    system.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node,
            gravity=list(body.pull),
            jointTypes=[exudyn.JointType.RevoluteZ, exudyn.JointType.RevoluteX][-count:],
            linkParents=list(range(-1, count - 1)),
            jointTransformations=exudyn.Matrix3DList([np.eye(3)] * count),
            jointOffsets=exudyn.Vector3DList([list(link.place) for link in links]),
            linkInertiasCOM=exudyn.Matrix3DList(moments),
            linkCOMs=exudyn.Vector3DList([list(link.centre) for link in links]),
            linkMasses=[link.mass for link in links],
            jointPControlVector=[link.stiffness for link in links],
            jointDControlVector=[link.damping for link in links],
            jointPositionOffsetVector=[0.0] * count,
            jointVelocityOffsetVector=[0.0] * count,
            forceUserFunction=push if body.forcing else 0,
        )
    )
    kinds = (exudyn.OutputVariableType.Coordinates, exudyn.OutputVariableType.Coordinates_t)
    sensors = [
        system.AddSensor(
            items.SensorNode(
                nodeNumber=node, storeInternal=True, writeToFile=False, outputVariableType=kind
            )
        )
        for kind in kinds
    ]
    system.Assemble()
    return system, (sensors[0], sensors[1]), container


def _options(settings: Options, steps: int, step: float) -> Any:
    import exudyn

    chosen = exudyn.SimulationSettings()
    integration = chosen.timeIntegration
    solution = chosen.solution
    integration.numberOfSteps = steps
    integration.endTime = steps * step
    integration.verboseMode = 0
    integration.adaptiveStep = False
    if "relativeTolerance" in settings:
        integration.newton.relativeTolerance = settings["relativeTolerance"]
        integration.newton.absoluteTolerance = settings["relativeTolerance"]
    solution.file.write = False
    solution.sensors.writePeriod = 0.5 * step  # every step, in spite of rounding
    return chosen


ENGINE = Engine("exudyn", "exudyn", METHODS, prepare, model_error_on_platform, optional=True)
