"""The contract on import names: every module of ours is imported as `plumbob.…` and once."""

from pathlib import Path

from plumbob.tests.contracts.tree import LAYERS, PACKAGE


def second_copies(modules, root):
    """Names of `modules` (as `sys.modules` has them) under which a module of the tree at `root` is
    imported a second time: a layer's bare name, or the name of the folder of the checkout."""
    names = {*LAYERS, root.name} - {PACKAGE}
    return sorted(
        name
        for name, module in modules.items()
        if name.split(".")[0] in names and _within(module, root)
    )


def _within(module, root):
    """Whether a module, or the folder of a package without a file, lies in the tree at `root`."""
    places = [getattr(module, "__file__", None), *getattr(module, "__path__", ())]
    return any(
        Path(place).resolve().is_relative_to(root.resolve()) for place in places if place
    )
