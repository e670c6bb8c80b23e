"""The contract on words: text uses the terms of numerical analysis and robotics.

Each pattern is a word that a robotics engineer would have to guess at, or that has another meaning
in the field; beside it stands the term to use.
"""

import re
from functools import cache

from plumbob.tests.contracts.tree import texts

TERMS = (  # pattern, what to write in its place; a space stands for any white space or underscore
    (r"foretell(s|ing)?|foretold|told", "predict, predicted"),
    (r"climb(s|ed|ing)?|rungs?|ladders?", "convergence study, step sizes"),
    (r"sag(s|ged|ging)?|sink(s|ing)?|sank|sunk", "static penetration, contact deflection"),
    (r"riding", "deflection dynamics"),
    (r"heave(s|d)?|heaving", "vertical displacement"),
    (r"slips? felt", "tangential-normal coupling"),
    # A sweep over parameters is the field's own term.
    (r"(solver|impulse|seidel|pymunk)(.s)? sweep(s|ing)?", "solver iterations"),
    (
        r"(sweep(s|ing)?|swept) (of|over) (the )?(impulses|contacts|constraints)",
        "solver iterations",
    ),
    (r"kink(s|ed|ing)?|bends", "acceleration discontinuities"),
    (r"chords", "position-first stepping"),
    (r"stretch(es)?", "smooth segment"),
    (r"staging|staged", "set-up"),
    (r"errs|erred|erring|(to|may|can|will|must) err", "the error is"),  # `err` alone is stderr
    (r"(is|are|was|were|be|how far) off by", "the error is"),
    (r"least (error|wrong|exact)", "smallest error, at which step"),
    (r"dear(er|est|ly)?", "expensive, costs more"),
    (r"in a hurry|hurried|hurry", "quick profile"),
    (r"as exact", "at equal accuracy"),
    (r"as (it|they) comes?|as shipped|as (it|they) ships?", "default settings"),
    (r"of itself|of themselves", "relative, per cent"),
    (r"yardsticks?", "reference step time"),
    (r"idle stages?", "disabled pipeline stages"),
    (r"witness(es|ed)?", "independent method"),
    (r"mends?|mended|mending", "fixes"),
    (r"trains?", "repeated manoeuvres"),
    (r"yours|mine", "user model, user settings"),
    (r"teeth", "sensitivity test"),
    (r"the house|house|rooms?", "packages, layers"),
    (r"the words", "glossary"),
    (r"surplus(es)?", "model-error bound"),
    (r"(a|an|the|its|own|equal|no) shares?|shares? of", "model-error bound, fraction, load"),
    (r"whence|thence|thereof|whereof|wherein|amiss|lest", "plain English"),
)
EXCEPTIONS = (  # names that users type
    r"capsule-hold|capsule-train|capsule_train",
    r"mujoco/mine",
)
FREE = ("LICENSE", "tests/contracts/wording.py")  # others' words; these words as data
GAP = r"(?:_|[\s#*\"'|>]+)"  # between the words of a phrase: line ends, and what begins a line
# of a word, or of a part of a CamelCase one
START = r"(?:(?<![A-Za-z])|(?<=[a-z0-9])(?=[A-Z]))"
END = r"(?:(?<=[a-z])(?![a-z])|(?<=[A-Z])(?![A-Za-z]))"


@cache
def pattern():
    """All forbidden words as one regular expression, a group each."""
    # groups inside a term's pattern have no number of their own
    inside = (re.sub(r"\((?![?])", "(?:", words).replace(" ", GAP) for words, _ in TERMS)
    return re.compile(f"{START}(?i:{'|'.join(f'({words})' for words in inside)}){END}")


def forbidden_words(root):
    """Words in names, docstrings, comments, messages, templates and READMEs that the field does
    not use, each with the term in its place."""
    found = []
    for path, text in texts(root):
        if path.as_posix() in FREE:
            continue
        for exception in EXCEPTIONS:
            text = re.sub(exception, lambda match: " " * len(match.group()), text)
        for match in pattern().finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            word = " ".join(match.group().split())
            _, term = TERMS[(match.lastindex or 1) - 1]
            found.append(f"{path}:{line}: {word!r}: write: {term}")
    return found
