"""Fields of a model file that engines' own readers take over: tested with the engines of the study,
and listed for the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from plumbob.engines.abilities import ModelReader
from plumbob.engines.registry import find_engine
from plumbob.engines.study.extra_runs import StudyPlan
from plumbob.engines.study.model_reading import ModelRead, ModelReading, fields_stated
from plumbob.engines.study.results import Study
from plumbob.reports.analyses.analysis import Analysis, Record
from plumbob.reports.analyses.measurements import study_plan
from plumbob.reports.judge.model_readers import (
    REFERENCE_READER,
    FileReading,
    compared_reading,
    ignored_options,
)

# measured by reading a file; a test repeats the reading with the installed engines
READER_RECORDS: Mapping[str, Record] = MappingProxyType(
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
)


def requests(plan: StudyPlan) -> Sequence[ModelReading]:
    """Returns a reading for each engine of the plan that reads model files, MuJoCo first; none
    without MuJoCo, which defines the format."""
    engines = {method.engine for method in plan.methods}
    if REFERENCE_READER not in engines:
        return ()
    in_order = (REFERENCE_READER, *sorted(engines - {REFERENCE_READER}))
    readers = [name for name in in_order if find_engine(name).ability(ModelReader) is not None]
    return tuple(map(ModelReading, readers))


def numbers(study: Study) -> Record | None:
    """Returns the fields that each reader takes over; None if MuJoCo read nothing."""
    readings = {r.engine: study.answer(r) for r in requests(study_plan(study))}
    rule = readings.get(REFERENCE_READER)
    if rule is None or rule.refuses:
        return None
    readers = [_reader(engine, rule, read) for engine, read in readings.items() if read]
    unread = {
        engine: known for engine, known in READER_RECORDS.items() if not readings.get(engine)
    }
    return Record(
        fields=fields_stated(rule.fields),  # fields that MuJoCo reads
        readers=readers,  # readers of this study, MuJoCo first
        # listed readers of engines that the study did not use
        others=[Record(engine=engine, **vars(known)) for engine, known in unread.items()],
        rule=REFERENCE_READER,
    )


def _reader(engine: str, rule: ModelRead, read: ModelRead) -> Record:
    """Returns the fields that an engine reads and those that it drops, compared with MuJoCo's."""
    reader = FileReading(engine, read.refuses)
    if not read.refuses:
        never_read = ignored_options(rule.fields, read.fields)
        reader = compared_reading(engine, rule.fields, read.fields, never_read)
    return Record(
        engine=engine,
        version=read.version,
        read=reader.read,
        refuses=read.refuses,  # why the engine refuses the file
        dropped=reader.dropped or {},  # {field: value of the engine in its place}
    )


READERS = Analysis("engines/model_readers", numbers, requests)
