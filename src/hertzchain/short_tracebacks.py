"""Short tracebacks of errors in IPython: the lines of the user, and the message."""

from __future__ import annotations

import traceback
from types import TracebackType

PACKAGE, USER = "hertzchain", "__main__"
# Mode of IPython's tracebacks, set by ``%xmode``, in which all frames are shown.
COMPLETE = "Verbose"


def short_traceback(error: BaseException) -> list[str]:
    """Lines of a traceback without frames of this package and of the packages that it calls.

    Causes are omitted, too.  The exception keeps its traceback, which ``%debug`` enters, and
    IPython shows it after ``%xmode Verbose``.
    """
    from IPython.core.getipython import get_ipython

    shell = get_ipython()
    short = _frames_of_user(error.__traceback__)
    if shell is None:
        return traceback.format_exception(error)
    if shell.InteractiveTB.mode == COMPLETE or short is None:
        short, shown = error.__traceback__, error
    else:
        shown = type(error)(*error.args)
    lines: list[str] = shell.InteractiveTB.structured_traceback(
        type(error), shown, short, tb_offset=0 if shown is not error else 1
    )
    return lines


def _frames_of_user(found: TracebackType | None) -> TracebackType | None:
    """A traceback of the frames above this package, and of later ones in the user's own code."""
    kept: list[TracebackType] = []
    below = False
    while found is not None:
        name = found.tb_frame.f_globals.get("__name__", "")
        package = name.partition(".")[0]
        below = below or package == PACKAGE
        if package != "IPython" and (name == USER or not below):
            kept.append(found)
        found = found.tb_next
    short = None
    for each in kept[::-1]:
        short = TracebackType(short, each.tb_frame, each.tb_lasti, each.tb_lineno)
    return short
