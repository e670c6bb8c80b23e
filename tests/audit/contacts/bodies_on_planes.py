"""Bodies on planes for the contact audit: none of them plumbob's own."""

from functools import cache

import mujoco

from plumbob.reports.audit_from_python import audit_contacts
from plumbob.tests.mujoco.test_settings import BODIES

FRICTION, GRAVITY, SPEED = 0.3, 9.81, 0.5
EXACT = SPEED**2 / (2 * FRICTION * GRAVITY)  # stopping distance [m]
FLOOR = '<geom name="floor" type="plane" size="5 5 1"/>'
# A disc on three feet, so flat that friction does not shift their loads.
FLAT = '<geom type="cylinder" size=".2 .0001" mass="1" contype="0" conaffinity="0"/>' + "".join(
    f'<geom name="foot_{i}" size=".001" pos="{x} {y} 0" mass="1e-4"/>'
    for i, (x, y) in enumerate([(0.15, 0.0), (-0.1, 0.12), (-0.1, -0.12)])
)


def model_text(
    body, height, option='timestep="0.002"', floor=FLOOR, friction=FRICTION, more=""
):
    """A model file with the geoms `body` of a free body on a plane."""
    return (
        f'<mujoco><option {option}/><default><geom friction="{friction}"/></default><worldbody>'
        f'{floor}<body name="base" pos="0 0 {height}"><freejoint/>{body}</body></worldbody>{more}'
        "</mujoco>"
    )


def texts():
    """{name: model file} of the three bodies that settings are tried on."""
    return {name: model_text(geoms, height) for name, (geoms, height, _) in BODIES.items()}


@cache
def audited_once(text):
    """The contact audit of a model file with default options, made once in a process."""
    return audit_contacts(mujoco.MjModel.from_xml_string(text))
