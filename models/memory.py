"""The text of an ImportError that is raised if memory does not suffice to load a library.

The command line imports this module before anything else: once memory is exhausted, it cannot
import.
"""

UNMAPPED = "failed to map segment"  # text of glibc's message
