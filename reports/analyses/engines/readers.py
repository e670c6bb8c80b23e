"""Which fields of a model file engines' own readers take over: read by the engines of the study,
and known of the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from plumbob.engines.abilities import ModelReader
from plumbob.engines.registry import find_engine
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.model_reading import ModelRead, ModelReading, fields_stated
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import plan_of
from plumbob.reports.judge.model_readers import (
    REFERENCE_READER,
    FileReading,
    compared_reading,
    ignored_options,
)

KNOWN: Mapping[str, Record] = MappingProxyType(
    {
        "dart": Record(version="6.20.0", read=("mass", "damping", "friction")),
        "drake": Record(
            version="1.51.1",
            read=("gravity", "mass", "inertia", "armature", "damping", "friction", "kp"),
        ),
        "newton": Record(
            version="1.8.0",
            read=(
                *("mass", "inertia", "armature", "damping", "stiffness", "frictionloss"),
                *("friction", "solref", "solimp", "gear", "kp", "kv"),
            ),
        ),
        "pinocchio": Record(
            version="4.1.0", read=("mass", "inertia", "armature", "damping", "frictionloss")
        ),
        "pybullet": Record(version="3.2.7", read=("mass", "friction")),
    }
)  # by reading, which a test repeats where they are installed


def requests(plan: StudyPlan) -> Sequence[ModelReading]:
    """The readings of those of the plan's engines that read files, MuJoCo's first; none without
    MuJoCo, whose format it is."""
    engines = {method.engine for method in plan.methods}
    first = (
        (REFERENCE_READER, *sorted(engines - {REFERENCE_READER}))
        if REFERENCE_READER in engines
        else ()
    )
    return tuple(
        ModelReading(e) for e in first if find_engine(e).ability(ModelReader) is not None
    )


def numbers(study: Study) -> Record | None:
    """Which fields each reader takes over; None where MuJoCo read nothing."""
    every = {request.engine: study.answer(request) for request in requests(plan_of(study))}
    rule = every.get(REFERENCE_READER)
    if rule is None or rule.refuses:
        return None
    readers = [_reader(engine, rule, read) for engine, read in every.items() if read]
    return Record(
        fields=fields_stated(rule.fields),  # that MuJoCo reads
        readers=readers,  # in this study, MuJoCo first
        # known of engines that the study did not read with
        others=[Record(engine=e, **vars(of)) for e, of in KNOWN.items() if not every.get(e)],
        rule=REFERENCE_READER,
    )


def _reader(engine: str, rule: ModelRead, read: ModelRead) -> Record:
    """The fields that an engine takes over."""
    beside = FileReading(engine, read.refuses)
    if not read.refuses:
        never = ignored_options(rule.fields, read.fields)
        beside = compared_reading(engine, rule.fields, read.fields, never)
    return Record(
        engine=engine,
        version=read.version,
        read=beside.read,
        refuses=read.refuses,  # why it reads nothing
        dropped=beside.dropped or {},  # {field: what is there instead}
    )


READERS = Analysis("engines/model_readers", numbers, requests)
