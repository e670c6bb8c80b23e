"""Compute the numbers of findings that no measurement enters, and write them into the files of
`reports/exact_numbers` that are shipped with the package.

    python -m plumbob.tests.validation.exact_numbers [TEMPLATE ...]

Writes the file of each named template, as "cone_pendulum/uniformity"; without a name, of all of
them, which takes a minute. A file holds the day, the versions of the packages, and the numbers, a
line for each name. Look at the differences before they are committed: a number that changes says
that an exact motion has.
"""

import argparse
import json
import sys

from plumbob.engines.study.codec import unstructured
from plumbob.engines.study.provenance import DIGITS, provenance
from plumbob.models.registry import built_in_systems
from plumbob.reports.analyses import section
from plumbob.reports.records.exact_numbers import ExactNumbers, exact_numbers_file
from plumbob.reports.records.plain_data import FOR_TEMPLATES, plain

# packages whose versions exact motions depend on
PACKAGES = ("plumbob", "Python", "numpy", "scipy", *DIGITS)


def exact_analyses():
    """The analyses that have exact numbers, by template."""
    sections = (section(name) for name in built_in_systems())
    shown = [of for known in sections if known for of in (*known.findings, *known.galleries)]
    return {analysis.template: analysis for analysis in shown if analysis.exact}


def computed_now(analysis):
    """The exact numbers of an analysis, computed here and now, as they are shipped."""
    made_with = provenance("")
    versions = {package: made_with.versions[package] for package in PACKAGES}
    numbers = plain(analysis.exact(), FOR_TEMPLATES)
    return ExactNumbers(made_with.date.partition(" ")[0], versions, numbers)


def text_of(exact):
    """The text of a file: JSON with a line for each entry, and for each number's name."""
    entries = unstructured(exact)
    lines = [f"{json.dumps(name)}: {json.dumps(of)}" for name, of in entries["numbers"].items()]
    return (
        f'{{"date": {json.dumps(entries["date"])},\n'
        f'"versions": {json.dumps(entries["versions"])},\n'
        f'"numbers": {{\n' + ",\n".join(lines) + "\n}}\n"
    )


def main(arguments):
    """Write the files; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    known = exact_analyses()
    parser.add_argument("templates", nargs="*", metavar="TEMPLATE", help="default: all of them")
    chosen = parser.parse_args(arguments).templates or list(known)
    for template in chosen:
        if template not in known:
            parser.error(f"{template} is none of {', '.join(known)}")
    for template in chosen:
        file = exact_numbers_file(template)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text_of(computed_now(known[template])), "utf-8")
        print(file)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
