"""Exit codes of the command line.

====================  ======================================================================
`DONE`                everything that was requested is done
`FAILED`              the request was sound, but a run cannot finish, points of a sweep failed
                      or are missing, a worker ended, the disk is full, stdout is closed
`BAD_INPUT`           bad usage, or input that cannot be used: chains, options, and paths that
                      are missing, damaged, in use, not writable or somebody else's
`OUTSIDE_TOLERANCE`   finished, but a number is outside its tolerance
`INTERRUPTED`         Ctrl-C
====================  ======================================================================
"""

DONE, FAILED, BAD_INPUT, OUTSIDE_TOLERANCE, INTERRUPTED = 0, 1, 2, 3, 130
