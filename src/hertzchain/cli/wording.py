"""Messages of the library in the words of the command line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import click
from click.core import ParameterSource

from ..errors import InputError, SimulationError

# Key of a context with the first names of options that were typed by another name, and this name.
TYPED: Final = "hertzchain.typed_options"
# Python expressions in messages, and what to write on the command line or in a chain file instead.
WORDINGS: Final = (
    (r"\bwith_cap\('([^']*)'\)", r"cap = '\1' in [chain]"),
    (r"\buse simulate with loss=ElasticPlastic\(\)",
     "use hertzchain simulate --loss elastic-plastic"),
    (r"\buse simulate with loss=ElasticPlastic\(yield_overlap=\.\.\.\)",
     "use hertzchain simulate with loss = {law = 'elastic-plastic', yield_overlap = ...} in the "
     "chain file"),
    (r"\buse loss=ElasticPlastic\(\)", "use loss = {law = 'elastic-plastic'} in the chain file"),
    (r"\buse loss=ElasticPlastic\(yield_overlap=\.\.\.\)",
     "use loss = {law = 'elastic-plastic', yield_overlap = ...} in the chain file"),
    (r"\bgive ElasticPlastic\(yield_pressure='5 MPa'\) or materials with yield_strength",
     "give yield_strength in [materials.NAME] of a chain file, or yield_pressure = '5 MPa' in "
     "[chain.loss] or in a [[chain.loss]] with between"),
    (r"\buse loss=ElasticPlastic\(factor=([\d.]+)\)",
     r"use loss = {law = 'elastic-plastic', factor = \1} in the chain file"),
    (r"\b(omit (?:it|them|the walls?)): chain\.replace\([^)]*\)", r"\1"),
    (r"^--wall must be same, rigid, (?=a material)", "--wall must be same, rigid, none, "),
    (r"^the chain has no (right )?wall; add a right_wall$",
     r"the chain has no \1wall; add --wall MATERIAL"),
    (r"\bomit the wall (?=behind a free body)", "omit the wall (--wall none) "),
    (r"\bloss=None\b", "no loss"),
    (r"\buse Wall\.rigid\(\)", "use --wall rigid, or rigid = true in the chain file"),
    (r"(?<!\.)\bpiecewise_local_rate (?=for steps)", "the method piecewise-local-rate "),
    (r"\bgive it for the pair \(('[^']*'), ('[^']*')\) or for 'others'",
     r"give it in a table with between = [\1, \2], or in one without between"),
    (r"\bloss=Elastic\(\) for (left_wall and right_wall|\w+_wall|a wall of \w+ \w+)",
     r"loss = {law = 'elastic'} for \1 in the chain file"),
    (r"\bwith Material\(name, density=, young=, poisson=\), or \[", "as ["),
    (r"\buse Chain\.from_materials, or relative$", "give a material and sizes, or --scatter"),
    (r"\bchain\.struck_by\(\)", "struck_by = {velocity = '1 m/s'} in the chain file"),
    (r"\(end=\.\.\. of load_drive\)", "(key end of [chain.drive])"),
    (r"\buse largest_so_far\b", "use the largest force so far"),
    (r"\bsimulate with until='([^']*)'", r"add --until '\1'"),
    (r"\bgive fit until='([^']*)'", r"add --until '\1'"),
    (r"\buntil='([^']*)'", r"--until '\1'"),
    # In a specification of a sweep, it is the key method.max_steps.
    (r"(?<![-.'])\bmax_steps\b", "--max-steps"),
    (r"\bgive load_traces sensors=\{'([^']*)': '([^']*)'\}", r"add --sensor '\1=\2'"),
    (r"\bgive channels=True \(on the command line: --channels\)", "add --channels"),
    (r"\bas in sensors=\{'([^']*)': '([^']*)', '([^']*)': '([^']*)'\}",
     r"as in --sensor '\1=\2' --sensor '\3=\4'"),
    (r"\bgive (the )?noise\b", "give --noise"),
    (r"\btraces\.with_scaled_times\((\S+)\) corrects them", r"multiply them by \1 in the file"),
    (r"\(scan_defects\)", "(--defects)"),
    (r"\(compare_losses\)", "(--laws all)"),
    (r"\(start=\{'([^']*)': \.\.\.\}\)", r"(--start '\1=...')"),
    (r"\bcompare_losses compares", "--laws all compares"),
    (r"\badd '([^']*)' to the free parameters \(also_free\)", r"add --also-free '\1'"),
    (r"(?<=to the free parameters) \(also_free\)", " (--also-free)"),
    (r"(?<=such as )\(0\.3, 0\.003\)", "0.3,0.003"),
    (r"(gain(?:\[[^]]*\])?) is not known: give it a prior(?: in( [^,]*))?, or a start such as "
     r"\{[^}]*\}",
     r"\1 is not known: add --prior '\1=0.01\2,0.0003\2', or give it in [fit.prior] or [fit.start] "
     r"of the chain file"),
    (r"\bcheck the given time offset,", "check --time-offset, or time_offset in [fit],"),
    (r"\bcheck with run\.horizon\(\)", "check with --horizon"),
    (r"\bhc\.simulate\(result\.chain\)\.horizon\(\)", "hertzchain simulate --horizon"),
    (r"\bhc\.scoreboard\(\)", "hertzchain scoreboard"),
    (r"(choose a value of the others, such as) (?!--at)", r"\1 --at "),
    (r"(choose a method, such as) approach='([^']*)', or a value, such as ",
     r"\1 --at approach=\2, or a value, such as --at "),
)  # fmt: skip

# ... and with commands that have an option for it.
BY_OPTION: Final = {
    "striker": ((r"such as chain\.struck_by\(\)", "such as --striker 1"),),
    "some": (
        (r"^beads = '", "--only '"),
        (r"^beads must be selected", "--only must select beads"),
    ),
    "contact": ((r"^contact must be", "--transfer must be"),),
    "times": (
        (r"\btimes=(\d+) is enough", r"--times \1 is enough"),
        (r"\bgive simulate more times\b", "give more --times"),
    ),
    "until": (
        (r"\bgive until\b(?!=)", "give --until"),
        (r"\bgive a later until\b", "give a later --until"),
        (r"(; give .*), or until$", r"\1, or --until"),
        (r"\bwithout until\b", "without --until"),
    ),
    "drift": (
        (
            r"^step and drift require method .*",
            "--step and --drift require --method symplectic, verlet or forward-4",
        ),
    ),
    "methods": (
        (r", or until$", ""),
        (r"\bgive until\b.*", "use hertzchain simulate --until"),
        (r"\buse simulate, or bca\(.*restitution=e\)", "use --method simulate"),
        (r"\buse propagate or simulate\b", "use --method propagate or --method simulate"),
        (
            r"\buse simulate with loss=ElasticPlastic\(\)",
            "use --method simulate --loss elastic-plastic",
        ),
        (
            r"\buse simulate with loss=ElasticPlastic\(yield_overlap=\.\.\.\)",
            "use --method simulate with loss = {law = 'elastic-plastic', yield_overlap = ...} in "
            "the chain file",
        ),
        (r"\buse simulate\b", "use --method simulate"),
        (r"\buse propagate\b", "use --method propagate"),
        (r"\buse bca or theory\.two_thirds_bca", "use --method bca or --method two-thirds-bca"),
        (r"\buse (propagate_many with Chain\.with_scatter|distribution)", "use hertzchain scatter"),
        (
            r"^disorder requires .*",
            "--method disorder requires a --scatter or --modulus-scatter "
            "above 0; for a chain without scatter, use --method local-rate",
        ),
        (r"\buse hertzchain\.simulate\([^)]*\)\.pulse\(\)", "use --method simulate"),
        (r"\bpiecewise_local_rate (?=for steps)", "--method piecewise-local-rate "),
    ),
    "cap": (
        (r"\bwith_cap\('([^']*)'\)", r"--cap '\1'"),
        (
            r"such as (right_wall=)?Wall\('5 kN/mm', exponent=1\)( for a load cell)?",
            "such as --wall '5 kN/mm'",
        ),
        (r"; set the wall before the cap, or give the mass", "; add --wall, or give the mass"),
    ),
    "loss": (
        (r"\buse loss=ElasticPlastic\(\)", "add --loss elastic-plastic"),
        (
            r"\bsearch with loss=ElasticPlastic\(\)",
            "search with loss elastic-plastic (--loss elastic-plastic)",
        ),
        (r"\(loss=ElasticPlastic\(\)\)", "(--loss elastic-plastic)"),
        (
            r"(?:use )?\bloss=ElasticPlastic\(factor=([\d.]+)\)",
            r"--loss 'elastic-plastic, factor=\1'",
        ),
        (
            r"\bgive ElasticPlastic\(yield_pressure='5 MPa'\) or materials with yield_strength",
            "give --loss 'elastic-plastic=5 MPa', or yield_strength in [materials.NAME] or a "
            "[[chain.loss]] with between in a chain file",
        ),
    ),
}


@contextmanager
def in_words_of_the_command() -> Iterator[None]:
    """Change messages of errors while the options of the command are known."""
    try:
        yield
    except (InputError, SimulationError) as error:
        error.args = (with_typed_names(on_command_line(str(error))),)
        raise
    except click.UsageError as error:
        if type(error) is not click.UsageError:
            raise
        raise click.UsageError(with_typed_names(error.message), error.ctx) from error.__cause__


def with_typed_names(message: str) -> str:
    """The message with options by the names that were typed, such as --velocity, not --speed."""
    context = click.get_current_context(silent=True)
    for name, typed in ({} if context is None else context.meta.get(TYPED, {})).items():
        message = re.sub(rf"(?<![\w-]){name}(?![\w-])", typed, message)
    return message


def _with_dashes(message: str, context: click.Context) -> str:
    """The message with the option in the place of the argument that it is about, if it is given."""
    name, space, rest = message.partition(" ")
    option = f"--{name.replace('_', '-')}"
    for param in context.command.params:
        given = context.get_parameter_source(param.name or "") == ParameterSource.COMMANDLINE
        if given and param.name == name and option in param.opts:
            return f"{option}{space}{rest}"
    return message


def on_command_line(message: str) -> str:
    """The message without Python expressions for which the command line has other words."""
    context = click.get_current_context(silent=True)
    own = () if context is None else context.params
    chosen = [pair for option, pairs in BY_OPTION.items() if option in own for pair in pairs]
    for expression, words in (*chosen, *WORDINGS):
        message = re.sub(expression, words, message)
    return message if context is None else _with_dashes(message, context)
