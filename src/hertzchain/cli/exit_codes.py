"""Exit codes of the command line.

====================  ======================================================================
`DONE`                the command succeeded
`FAILED`              the input was valid, but a run cannot finish, points of a sweep failed
                      or are missing, a worker ended, the disk is full, or stdout is closed
`BAD_INPUT`           bad usage or invalid input: chains, options, and paths that are missing,
                      corrupted, in use, not writable or not written by hertzchain
`OUTSIDE_TOLERANCE`   the command finished, but a number is outside its tolerance
`INTERRUPTED`         the command was interrupted (Ctrl-C)
====================  ======================================================================
"""

DONE, FAILED, BAD_INPUT, OUTSIDE_TOLERANCE, INTERRUPTED = 0, 1, 2, 3, 130
