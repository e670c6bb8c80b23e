"""Fast bodies and thin walls at random, and whether steps of a microsecond touch: an answer that no
code of the audit takes part in."""

import math

import mujoco
import numpy as np

from plumbob.engines.adapters.mujoco.own_model.model import own_model
from plumbob.engines.audit.controls import script
from plumbob.engines.own_motion import Start
from plumbob.tests.audit.scenes_as_models import compiled

FINE = 1e-6  # [s]
STEP = 0.002  # [s]
DURATION = 0.04  # [s]
SPEEDS = (5.0, 200.0)  # [m/s]
THICKNESS = (2e-4, 5e-3)  # [m]
SCENE = """
<mujoco>
  <option timestep="{step}" gravity="0 0 {gravity}" integrator="{integrator}"/>
  <worldbody>{bodies}</worldbody>
  <keyframe><key qvel="{qvel}" qpos="{qpos}"/></keyframe>
</mujoco>
"""


def numbers(values):
    return " ".join(f"{value:.9g}" for value in np.ravel(values))


def log_uniform(rng, low, high):
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def flying(rng, speed, kind=None):
    """A free body along the x axis, spinning: its geom, position, velocity and radius."""
    kind = kind or rng.choice(["sphere", "box", "capsule", "cylinder", "ellipsoid"])
    sizes = rng.uniform(0.002, 0.02, 3)
    geom = f'<geom type="{kind}" size="{numbers(sizes)}" density="1000"/>'
    turn = rng.normal(size=4)
    spin = rng.normal(size=3) * rng.choice([0.0, 20.0, 200.0])
    place = [*np.zeros(3), *(turn / np.linalg.norm(turn))]
    reach = sizes[0] if kind == "sphere" else float(np.linalg.norm(sizes))
    return f"<body><freejoint/>{geom}</body>", place, [speed, 0, 0, *spin], reach


def wall(rng, distance, offset, thickness, speed):
    """A thin box across the x axis, whose edge is `offset` beside the axis; it slides along the x
    axis at a speed, or is fixed."""
    half = rng.uniform(0.02, 0.5)
    at = numbers([distance, offset - half, 0.0])
    size = numbers([thickness / 2.0, half, 0.5])
    geom = f'<geom type="box" size="{size}" density="1000"/>'
    if speed == 0.0:
        return f'<body pos="{at}">{geom}</body>', [], []
    return f'<body pos="{at}"><joint type="slide" axis="1 0 0"/>{geom}</body>', [0.0], [speed]


def shot(rng):
    """A body that flies at a wall, past its edge, or at another body."""
    speed = log_uniform(rng, *SPEEDS)
    body, place, velocity, reach = flying(rng, speed)
    thickness = log_uniform(rng, *THICKNESS)
    wall_speed = rng.choice([0.0, -1.0, 0.5]) * rng.uniform(0.0, speed)
    distance = (speed - wall_speed) * rng.uniform(0.1, 0.95) * DURATION + 2.0 * reach
    beside = rng.uniform(-1.0, 1.0) * reach if rng.random() < 0.5 else reach
    barrier, more, rate = wall(rng, distance, beside, thickness, wall_speed)
    return body + barrier, place + more, velocity + rate


def spun(rng):
    """A rod on a hinge whose tip meets a thin wall, or just misses it."""
    length, radius = rng.uniform(0.1, 0.5), rng.uniform(0.002, 0.005)
    rate = log_uniform(rng, *SPEEDS) / length
    reach = length + radius + rng.choice([-1.0, 1.0]) * log_uniform(rng, 1e-5, 2e-3)
    angle = rng.uniform(0.3, min(6.0, 0.95 * rate * DURATION + 0.3))
    thickness = log_uniform(rng, *THICKNESS)
    way = np.array([math.cos(angle), math.sin(angle), 0.0])
    place = numbers((reach + 0.05) * way)
    size = numbers([0.05, thickness / 2.0, 0.05])
    rod = (
        f'<body><joint type="hinge" axis="0 0 1"/>'
        f'<geom type="capsule" fromto="0 0 0 {length} 0 0" size="{radius}"/></body>'
    )
    target = f'<geom type="box" size="{size}" pos="{place}" euler="0 0 {math.degrees(angle)}"/>'
    return rod + target, [0.0], [rate]


def met(rng):
    """Two free bodies that meet, or pass each other."""
    speeds = [log_uniform(rng, *SPEEDS), -log_uniform(rng, *SPEEDS)]
    one, other = (flying(rng, speed) for speed in speeds)
    distance = (speeds[0] - speeds[1]) * rng.uniform(0.1, 0.9) * DURATION
    beside = rng.uniform(0.0, 1.1) * (one[3] + other[3])
    other[1][:3] = [distance + one[3] + other[3], beside, 0.0]
    return one[0] + other[0], one[1] + other[1], one[2] + other[2]


def scene(seed):
    """A compiled model of a number, whose keyframe is its start."""
    rng = np.random.default_rng(seed)
    make = (shot, spun, shot, met)[seed % 4]
    bodies, qpos, qvel = make(rng)
    return compiled(
        SCENE.format(
            step=STEP,
            gravity=rng.choice([0.0, -9.81]),
            integrator=rng.choice(["Euler", "RK4", "implicitfast"]),
            bodies=bodies,
            qpos=numbers(qpos),
            qvel=numbers(qvel),
        )
    )


def audited(seed):
    """A scene of a number, made ready for an audit, and its motion."""
    own = own_model(scene(seed), str(seed), Start(0))
    return own, script(own, duration=DURATION)


def first_touch(model, duration):
    """The time [s] at which steps of a microsecond touch first; infinite where they do not."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    model.opt.timestep = FINE
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    for _ in range(round(duration / FINE)):
        mujoco.mj_step(model, data)
        if data.ncon and (data.contact.dist < data.contact.includemargin).any():
            return float(data.time)
    return math.inf
