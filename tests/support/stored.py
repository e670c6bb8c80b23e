"""A study in a store, as if it had been measured into it."""

from plumbob.engines.study import store
from plumbob.engines.study.results import TaskResult
from plumbob.engines.study.stability import StabilitySearch, StepPrediction
from plumbob.engines.study.store_file import transaction, writing


def save(study, file):
    """Add a study to `file`, made if need be; returns its number."""
    results = {
        f"{c.scene} {c.method}": TaskResult(c, pair=(c.scene, c.method)) for c in study.convergence
    }
    for scene in study.scenes:
        by_method = {m: cost for (name, m), cost in study.costs.items() if name == scene.name}
        results[f"costs of {scene.name}"] = TaskResult(
            costs=by_method, reference_step=study.reference_step, pair=(scene.name, "")
        )
    for request, result in study.extras.items():
        pair = ("", "")
        if isinstance(request, StabilitySearch | StepPrediction):
            pair = request.scene, request.method
        results[str(request)] = TaskResult(extras={request: result}, pair=pair)
    with writing(file) as opened, transaction(opened):
        number, _ = store.begun(opened, "")
        store.keep(opened, number, results)
        store.complete(opened, number, study, results)
    return number
