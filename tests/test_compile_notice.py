import io
import os
import pty
import re
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
from numba.core.event import Event, EventStatus

from hertzchain.kernels import compile_notice, forces
from hertzchain.kernels.compile_notice import CompileNotice, write_line
from hertzchain.simulation import slow_run

LINE = "hertzchain: compiling once, about"
# A function that nothing has compiled yet, as if it belonged to the package.
COMPILE = """
import time
from hertzchain.kernels import compilation

def function(x):
    return x + 1

function.__module__ = "hertzchain.kernels.narrow_window"
kernel = compilation.njit(function)
compiler = kernel._compiler
before = compiler.compile
def compile_slowly(*given):
    time.sleep(0.8)
    return before(*given)
compiler.compile = compile_slowly
kernel(1), kernel(1.0), kernel(1j)
print("done")
"""


def events(module, arguments):
    dispatcher = SimpleNamespace(py_func=SimpleNamespace(__module__=module))
    return [
        Event("numba:compile", status, {"dispatcher": dispatcher, "args": arguments})
        for status in (EventStatus.START, EventStatus.END)
    ]


def compile_for(notice, seconds, module="hertzchain.kernels.narrow_window", arguments=()):
    start, end = events(module, arguments)
    notice.notify(start)
    # A function that the outer one calls.
    notice.notify(start)
    notice.notify(end)
    time.sleep(seconds)
    notice.notify(end)


def test_one_line_per_wait_however_many_functions_are_compiled():
    lines = []
    notice = CompileNotice(lines.append, delay=0.05, pause=0.3)
    for _ in range(3):
        compile_for(notice, 0.15)
    assert len(lines) == 1
    assert re.fullmatch(rf"{LINE} \d+ s", lines[0])
    time.sleep(0.4)
    compile_for(notice, 0.15)
    assert len(lines) == 2


def test_a_longer_compilation_in_the_same_wait_is_announced():
    lines = []
    notice = CompileNotice(lines.append, delay=0.05, pause=60.0)
    for module in ("narrow_window", "full_chain", "narrow_window", "full_chain"):
        compile_for(notice, 0.15, f"hertzchain.kernels.{module}")
    shorter, longer = (int(line.removeprefix(LINE).removesuffix(" s")) for line in lines)
    assert shorter < longer


def test_compiling_does_not_count_as_a_slow_run(monkeypatch):
    lines = []
    notice = CompileNotice([].append)
    monkeypatch.setattr(compile_notice, "_installed", [notice])
    monkeypatch.setattr(slow_run, "INTERVAL", 0.2)
    report = slow_run.slow_run_notice(lines.append)
    compile_for(notice, 0.3)
    report(1, 9)
    assert lines == []
    time.sleep(0.25)
    report(2, 9)
    assert len(lines) == 1


def test_a_short_compilation_is_silent_but_many_add_up():
    lines = []
    notice = CompileNotice(lines.append, delay=0.4, pause=60.0)
    compile_for(notice, 0.02)
    time.sleep(0.5)
    assert lines == []
    for _ in range(10):
        compile_for(notice, 0.05)
    assert len(lines) == 1


def test_functions_of_other_packages_are_ignored():
    lines = []
    notice = CompileNotice(lines.append, delay=0.0)
    compile_for(notice, 0.1, "somebody.kernels.narrow_window")
    compile_for(notice, 0.1, "__main__")
    compile_for(notice, 0.1, None)
    assert lines == []


class Screen(io.StringIO):
    def isatty(self):
        return True


class NotebookStream(io.StringIO):
    """As `ipykernel.iostream.OutStream`, which is not a terminal."""


NotebookStream.__module__ = "ipykernel.iostream"


@pytest.mark.parametrize(
    ("stream", "written"), [(Screen(), True), (NotebookStream(), True), (io.StringIO(), False)]
)
def test_only_terminals_and_notebooks(monkeypatch, stream, written):
    monkeypatch.setattr(sys, "stderr", stream)
    write_line("compiling")
    assert stream.getvalue() == ("compiling\n" if written else "")


def test_streams_that_are_missing_or_closed(monkeypatch):
    closed = Screen()
    closed.close()
    for stream in (None, closed):
        monkeypatch.setattr(sys, "stderr", stream)
        write_line("compiling")


def test_worker_processes_are_silent(monkeypatch):
    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(compile_notice.multiprocessing, "parent_process", object)
    write_line("compiling")
    assert screen.getvalue() == ""


def on_terminal(*command):
    """Standard output through a pipe, and what appears on a terminal as standard error."""
    master, slave = pty.openpty()
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=slave, text=True) as process:
        os.close(slave)
        shown = b""
        # At the end of the other side, Linux raises an error and others return nothing.
        while True:
            try:
                piece = os.read(master, 4096)
            except OSError:
                break
            if not piece:
                break
            shown += piece
        output = process.stdout.read()
    os.close(master)
    assert process.returncode == 0, shown.decode()
    return output, shown.decode()


def test_a_terminal_shows_the_line_once_and_a_pipe_shows_nothing():
    command = [sys.executable, "-c", COMPILE]
    output, shown = on_terminal(*command)
    assert output == "done\n"
    assert shown.count(LINE) == 1
    assert shown.endswith(" s\r\n")
    piped = subprocess.run(command, capture_output=True, text=True, check=True)
    assert (piped.stdout, piped.stderr) == ("done\n", "")


def test_the_command_line_writes_the_line_to_a_pipe():
    """Batch jobs and logs of CI have no terminal."""
    program = COMPILE.replace("kernel(1), kernel(1.0), kernel(1j)", "with_progress()")
    program = (
        "from hertzchain.cli.progress import progress_bar\n"
        "def with_progress():\n"
        "    with progress_bar('chains') as progress:\n"
        "        kernel(1), kernel(1.0)\n"
    ) + program
    piped = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert piped.stdout == "done\n"
    assert re.fullmatch(rf"{LINE} \d+ s\n", piped.stderr)
    _, shown = on_terminal(sys.executable, "-c", program)
    assert "0/?" not in shown
    assert shown.count("about") == 1
    assert shown.rpartition(" s\r\n")[2].count("hertzchain: compiling once") >= 1


def test_the_line_is_above_a_progress_bar():
    program = (
        "import sys, time; from hertzchain.cli.progress import progress_bar\n"
        "from hertzchain.kernels.compile_notice import write_line\n"
        "with progress_bar('chains') as progress:\n"
        "    progress(1, 2); time.sleep(0.3)\n"
        "    write_line('hertzchain: compiling once, about 10 s'); time.sleep(0.3)\n"
        "    progress(2, 2)\n"
    )
    _, shown = on_terminal(sys.executable, "-c", program)
    # The bar is erased before the line, and drawn again below it.
    before, after = shown.split(LINE)
    assert before.rpartition("chains")[2].count("\x1b[2K") >= 1
    assert re.match(r" 10 s *\r?\n.*chains", after, re.S)


def test_the_clock_continues_when_all_are_done():
    """After the last chain there may be further work, with nothing else to show."""
    program = (
        "import time; from hertzchain.cli.progress import progress_bar\n"
        "with progress_bar('chains') as progress:\n"
        "    progress(1, 2); progress(2, 2); time.sleep(2.5)\n"
    )
    _, shown = on_terminal(sys.executable, "-c", program)
    last = shown.rpartition("chains: 2, finishing")
    assert last[1]
    assert len(set(re.findall(r"0:00:0\d", shown.partition("finishing")[2]))) >= 2


def test_what_takes_long_is_announced_as_long():
    lines = []
    chain = SimpleNamespace(instance_class=forces.GeneralChain)
    for module, arguments in (("narrow_window", ()), ("full_chain", ()), ("full_chain", (chain,))):
        notice = CompileNotice(lines.append, delay=0.0)
        compile_for(notice, 0.1, f"hertzchain.kernels.{module}", arguments)
    seconds = [int(line.split()[-2]) for line in lines]
    assert seconds == sorted(set(seconds))
