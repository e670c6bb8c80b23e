"""The message of an ImportError if memory does not suffice to load a library.

The command line has it before it imports anything else: once memory is exhausted, it cannot.
"""

UNMAPPED = "failed to map segment"  # glibc's words
