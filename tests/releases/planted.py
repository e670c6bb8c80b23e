"""Planted releases of pymunk: wheels with the files of the installed package, under other versions
and with other steps."""

import zipfile
from importlib import metadata

# pymunk's step of a release, as a factor on the step [s] that it is asked for
PLANT = """
_step = Space.step
Space.step = lambda space, dt: _step(space, {factor} * dt)
"""
PACKAGE = "pymunk"


def write_wheel(folder, version, factor):
    """Writes a wheel of pymunk under this version into a folder. Its steps are `factor` times as
    long as they should be."""
    installed = metadata.distribution(PACKAGE)
    info = f"{PACKAGE}-{version}.dist-info"
    tag = installed.read_text("WHEEL").partition("Tag: ")[2].splitlines()[0]
    wheel = folder / f"{PACKAGE}-{version}-{tag}.whl"
    about = installed.read_text("METADATA")
    renamed = about.replace(f"Version: {installed.version}", f"Version: {version}", 1)
    with zipfile.ZipFile(wheel, "w") as archive:
        for file in installed.files:
            if file.parts[0] != PACKAGE or file.suffix == ".pyc" or "tests" in file.parts:
                continue
            content = file.locate().read_bytes()
            if file.as_posix() == f"{PACKAGE}/__init__.py":
                content += PLANT.format(factor=factor).encode()
            archive.writestr(file.as_posix(), content)
        archive.writestr(f"{info}/METADATA", renamed)
        archive.writestr(f"{info}/WHEEL", installed.read_text("WHEEL"))
        archive.writestr(f"{info}/RECORD", "")
