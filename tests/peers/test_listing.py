"""Looking at what there is loads no engine, whichever are installed."""

import subprocess
import sys

ENGINES = (
    *(
        "dartpy",
        "exudyn",
        "heyoka",
        "jax",
        "mujoco",
        "pinocchio",
        "plotly",
        "pybullet",
        "pydrake",
    ),
    *("pymunk", "scipy", "jinja2", "rich", "cattrs"),
)
LIST = """
import sys
from plumbob.reports.cli import main
code = main(["list"])
loaded = sorted({name.partition(".")[0] for name in sys.modules} & set(sys.argv[1:]))
print("loaded:", *loaded)
sys.exit(code)
"""


def test_a_list_of_engines_loads_none():
    command = [sys.executable, "-c", LIST, *ENGINES]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert "dart/default" in done.stdout
    assert done.stdout.splitlines()[-1] == "loaded:"
