"""Which fields of a model file engines' own readers take over: read by the engines of the study,
and known of the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.model_reading import EVERY_FIELD, ModelRead, ModelReading, readings
from plumbob.engines.study.request import Request
from plumbob.engines.study.results import Study
from plumbob.models.registry import find_system
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import plan_of
from plumbob.reports.judge.model_readers import RULE, Reader, compared, fields_stated, ignored

Readings = Mapping[ModelReading, ModelRead | None]
Ignoring = Mapping[str, tuple[str, ...]]  # by engine, the options that it takes from no file


KNOWN: Mapping[str, Record] = MappingProxyType(
    {
        "dart": Record(version="6.20.0", fields=("mass", "damping", "friction")),
        "drake": Record(
            version="1.51.1",
            fields=("gravity", "mass", "inertia", "armature", "damping", "friction", "gear"),
        ),
        "pinocchio": Record(
            version="4.1.0", fields=("mass", "inertia", "armature", "damping", "frictionloss")
        ),
        "pybullet": Record(version="3.2.7", fields=("mass", "friction")),
    }
)  # by reading, which a test repeats where they are installed


def requests(plan: StudyPlan) -> Sequence[Request[Any]]:
    """The models of the plan's systems, read by those of its engines that read any; none without
    MuJoCo, whose format it is."""
    engines = {method.engine for method in plan.methods}
    if RULE not in engines:
        return ()
    first = (RULE, *sorted(engines - {RULE}))
    names = dict.fromkeys(scene.system for scene in plan.scenes)
    return readings(first, [find_system(name) for name in names])


def numbers(study: Study) -> Record | None:
    """Which fields each reader takes over; None where MuJoCo read nothing."""
    results = {
        request: study.answer(request)
        for request in requests(plan_of(study))
        if isinstance(request, ModelReading)
    }
    rule = results.get(ModelReading(RULE, EVERY_FIELD))
    if rule is None or rule.refuses:
        return None
    every = {r.engine: read for r, read in results.items() if read and r.model == EVERY_FIELD}
    ignoring = {
        engine: ignored(rule.fields, read.fields)
        for engine, read in every.items()
        if not read.refuses
    }
    readers = [_fields_read(_reader(e, rule, r, ignoring), r.version) for e, r in every.items()]
    others = [
        _fields_read(Reader(e, "", of.fields), of.version)
        for e, of in KNOWN.items()
        if e not in every
    ]
    engines = tuple(dict.fromkeys(r.engine for r, read in results.items() if read))
    models = _own_models(results, engines, ignoring) if len(engines) > 1 else ()
    return Record(
        fields=fields_stated(rule.fields),  # that MuJoCo reads
        readers=readers,  # in this study, MuJoCo first
        others=others,  # known of engines that the study did not read with
        engines=engines,  # of the models' readers
        models=models,
        rule=RULE,
    )


def _fields_read(reader: Reader, version: str) -> Record:
    """The fields that an engine takes over of a model that has every field."""
    here = Record(version=version, fields=reader.read)
    known = here if reader.refuses else KNOWN.get(reader.engine, here)
    return Record(
        engine=reader.engine,
        version=version,
        read=reader.read,
        refuses=reader.refuses,  # why it reads nothing
        dropped=reader.dropped or {},  # {field: what is there instead}
        known=known,  # to be read; of another engine, or one that refuses, what is read here
        more=[name for name in reader.read if name not in known.fields],
        less=[name for name in known.fields if name not in reader.read],
    )


def _own_models(
    results: Readings, engines: Sequence[str], ignoring: Ignoring
) -> tuple[Record, ...]:
    """plumbob's own models against readers."""
    models = []
    for model in dict.fromkeys(r.model for r in results if r.model != EVERY_FIELD):
        rule = results[ModelReading(RULE, model)]
        if rule is None or rule.refuses:
            continue
        reads = {engine: results[ModelReading(engine, model)] for engine in engines}
        readers = (_reader(e, rule, read, ignoring) if read else None for e, read in reads.items())
        models.append(Record(model=model, fields=len(fields_stated(rule.fields)), readers=readers))
    return tuple(models)


def _reader(engine: str, rule: ModelRead, read: ModelRead, ignoring: Ignoring) -> Reader:
    """A reading beside MuJoCo's."""
    if read.refuses:
        return Reader(engine, read.refuses)
    return compared(engine, rule.fields, read.fields, ignoring.get(engine, ()))


READERS = Analysis("engines/model_readers", numbers, requests)
