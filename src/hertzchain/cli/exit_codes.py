"""With which code the command line leaves."""

DONE, FAILED, BAD_INPUT, OUTSIDE_TOLERANCE, INTERRUPTED = 0, 1, 2, 3, 130
