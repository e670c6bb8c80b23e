"""Write the table of engines and systems into engines/README.md, from a stored study.

    plumbob validate --out OUT
    python -m plumbob.tests.validation.engines_table OUT

The table is that of the page "Engines": the finding "errors-and-costs" of the newest study in the
folder OUT. It takes the place of the lines between two marks in the README; nothing else changes,
and nothing is run. Only a study of all systems and of all of plumbob's engines fills it.
"""

import argparse
import sys
from pathlib import Path

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.registry import engines
from plumbob.engines.study import store
from plumbob.engines.study.provenance import NOT_INSTALLED, PEERS
from plumbob.models.registry import built_in_systems
from plumbob.reports.analyses.engines.errors_and_costs import ERRORS_AND_COSTS, NOT_ENGINES
from plumbob.reports.view.finding_text import findings_of

PACKAGES = ("mujoco", "pymunk", "scipy", "heyoka", *PEERS)  # of engines
README = Path(__file__).parents[2] / "engines" / "README.md"
BEGIN = "<!-- Written by `python -m plumbob.tests.validation.engines_table OUT`: -->\n"
END = "<!-- Here ends the table of engines. -->\n"


def ours():
    """The names of plumbob's own engines that simulate, as the table has them."""
    names = (name for name, of in engines().items() if not of.distribution)
    return sorted(name for name in names if name not in NOT_ENGINES)


def system_names():
    """The names of plumbob's own systems."""
    return sorted(built_in_systems())


def system_of_row(row):
    """The name of the system of a row's scene."""
    return row[0].text.partition("/")[0]


def finding_of(study):
    """The finding of a study that has the table; None without one."""
    kept = [a for a in study.analyses if a.template == ERRORS_AND_COSTS.template and a.numbers]
    return findings_of(kept[0])[0] if kept else None


def measured_with(provenance):
    """A sentence with the versions and the machine that a study was measured with."""
    versions = provenance.versions
    packages = [f"{name} {versions[name]}" for name in PACKAGES if name in versions]
    there = ", ".join(text for text in packages if not text.endswith(NOT_INSTALLED))
    machine = provenance.machine
    return f"Measured with {there}, on {machine.get('processor', 'another machine')}.\n"


def text(finding):
    """The table of a finding as Markdown: a row a system, in the page's order."""
    tables = [table for table in finding.tables if table.filtered]
    heads = tables[0].heads
    rows = [heads, ("---",) * len(heads)]
    for row in (row for table in tables for row in table.rows):
        rows.append(tuple(cell.text.replace("\n", "; ") for cell in row))
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def filled(readme, table):
    """A README's text with another table between its marks; raises ParameterError if it does not
    have them once each, in their order."""
    before, begin, rest = readme.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end) or BEGIN in rest or END in after:
        raise ParameterError("README", str(README), "a text with the table's two marks, once")
    return f"{before}{BEGIN}\n{table}\n{END}{after}"


def main(arguments):
    """Write the table; returns an exit code: 2 where the study has none, or not all engines."""
    parser = argparse.ArgumentParser(description="Writes the table of engines/README.md.")
    parser.add_argument("out", metavar="OUT", help="a results folder of `plumbob validate`")
    out = parser.parse_args(arguments).out
    try:
        study = store.load(Path(out) / store.FILE)
        finding = finding_of(study) if study else None
        if finding is None:
            raise ParameterError("OUT", out, "a folder with a study of several engines")
        tables = [table for table in finding.tables if table.filtered]
        there = {*tables[0].heads, *(system_of_row(r) for table in tables for r in table.rows)}
        if missing := [name for name in (*ours(), *system_names()) if name not in there]:
            wanted = "a folder with a study of every engine and system, not one without "
            raise ParameterError("OUT", out, wanted + ", ".join(missing))
        written = f"{text(finding)}\n{measured_with(study.provenance)}"
        README.write_text(filled(README.read_text("utf-8"), written), "utf-8")
    except ParameterError as error:
        print(f"plumbob: {error}", file=sys.stderr)
        return 2
    print(f"written: {README}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
