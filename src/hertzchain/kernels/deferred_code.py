"""Compile functions that only kernels call to intermediate code, as parts of their callers.

Numba optimises each function together with all those that it calls, writes its machine code, and
does the same once more for each of its callers.  This takes a third of the time of compiling, and
the machine code of functions that Python does not call is never used.  With the compiler of this
module, only the functions that Python calls are optimised and become machine code.

Numba also omits the branches of ``if x is None`` that are never taken, with all that they call, but
only for an argument that is `None`.  This compiler omits them for other arguments, too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from llvmlite import binding
from numba import types
from numba.core import ir
from numba.core.analysis import dead_branch_prune
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import AnalysisPass, FunctionPass, register_pass
from numba.core.typed_passes import AnnotateTypes
from numba.core.untyped_passes import DeadBranchPrune

# The prefix of variables that hold the address of a function's environment.
ENVIRONMENT = "_ZN08NumbaEnv"
# Methods of numba that its documentation does not describe.
UNDOCUMENTED = (
    "_optimize_final_module", "_finalize_final_module", "_finalize_dynamic_globals",
    "_verify_declare_only_symbols",
)  # fmt: skip


class DeferredLibrary(JITCodeLibrary):
    """Intermediate code of a function and of those that it calls."""

    def _optimize_final_module(self) -> None:
        """Leave the optimisation to the callers."""

    def _finalize_final_module(self) -> None:
        """Make the code available to callers, but not to the engine that writes machine code."""
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        # Numba writes the address of each environment to a variable, which needs 64 bits.
        engine = self._codegen._engine
        names = [each.name for each in self._final_module.global_variables]
        new = [name for name in names
               if name.startswith(ENVIRONMENT) and not engine.is_symbol_defined(name)]  # fmt: skip
        if new:
            lines = [f'@"{name}" = common global i64 0' for name in new]
            engine.add_module(binding.parse_assembly("\n".join(lines)))
        self._finalized = True


@register_pass(mutates_CFG=False, analysis_only=True)
class DeferMachineCode(AnalysisPass):
    """Put the function that is being compiled into a `DeferredLibrary`."""

    _name = "defer_machine_code"

    def __init__(self) -> None:
        AnalysisPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Choose the library, which numba otherwise does when it lowers the function."""
        state.library = DeferredLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        return False


def count_branches(function: ir.FunctionIR) -> int:
    """Number of branches in the intermediate representation of a function."""
    return sum(isinstance(block.terminator, ir.Branch) for block in function.blocks.values())


class NotNone(NamedTuple):
    """The type of an argument that is never `None`; numba reads this field of literal types."""

    literal_type: types.Type


@register_pass(mutates_CFG=True, analysis_only=False)
class PruneBranchesOnNone(FunctionPass):
    """Remove branches that are taken only if an argument that is not `None` were `None`."""

    _name = "prune_branches_on_none"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Compare the types of the arguments with `None`."""
        may_be_none = types.NoneType, types.Omitted, types.Optional
        known = [each if isinstance(each, may_be_none) else NotNone(each) for each in state.args]
        before = count_branches(state.func_ir)
        dead_branch_prune(state.func_ir, known)
        # Numba analyses a changed function again, which takes time.
        return count_branches(state.func_ir) < before


class DeferringCompiler(CompilerBase):
    """Numba's usual passes, `PruneBranchesOnNone` and `DeferMachineCode`."""

    def define_pipelines(self) -> list[Any]:
        """Extend the usual passes."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(PruneBranchesOnNone, DeadBranchPrune)
        passes.add_pass_after(DeferMachineCode, AnnotateTypes)
        passes.finalize()
        return [passes]


def deferring() -> dict[str, Any]:
    """Options of `numba.njit` that defer machine code, if this version of numba can do it."""
    if not all(hasattr(JITCodeLibrary, name) for name in UNDOCUMENTED):
        return {}
    # Numba's cache holds the code as a part of the callers.
    return {"pipeline_class": DeferringCompiler, "cache": False}
