"""A study in a store, as if it had been measured into it."""

from plumbob.engines.study import store
from plumbob.engines.study.cost import SceneCosts
from plumbob.engines.study.results import TaskResult
from plumbob.engines.study.store_file import transaction, writing


def save(study, file):
    """Add a study to `file`, made if need be; returns its number."""
    results = {f"{c.scene} {c.method}": TaskResult(c, scene=c.scene) for c in study.convergence}
    for scene in study.scenes:
        by_method = {m: cost for (name, m), cost in study.costs.items() if name == scene.name}
        costs = SceneCosts(scene.name, by_method, study.reference_step)
        results[f"costs of {scene.name}"] = TaskResult(costs, scene=scene.name)
    for request, result in study.extras.items():
        scene = request.scene if getattr(request, "of_pair", False) else ""
        results[str(request)] = TaskResult(result, request, scene)
    with writing(file) as opened, transaction(opened):
        number, _ = store.study_number(opened, "")
        store.keep(opened, number, results)
        store.complete(opened, number, study, results)
    return number
