"""Functions that are compiled with and without a wrapper for Python."""

import pytest
from kernel_call import callable_from_python

from hertzchain.kernels import deferred_code
from hertzchain.kernels.compilation import OPTIONS, internal


@internal(**(OPTIONS | {"cache": False}))
def double(x):
    return 2.0 * x


def test_functions_of_kernels_cannot_be_called_by_mistake():
    with pytest.raises(TypeError, match="double has no wrapper for Python; call it from"):
        double(1.5)
    assert callable_from_python(double)(1.5) == 3.0


def test_machine_code_is_deferred_by_the_installed_numba():
    options = deferred_code.deferring()
    assert options["pipeline_class"] is deferred_code.DeferringCompiler
    callable_from_python(double)(2.5)
    (compiled,) = double.overloads.values()
    assert isinstance(compiled.library, deferred_code.DeferredLibrary)


def test_branches_on_none_are_not_compiled_for_other_arguments():
    @internal(**(OPTIONS | {"cache": False}))
    def of_none(x):
        return 2.0 * x

    @internal(**(OPTIONS | {"cache": False}))
    def of_value(x):
        return 3.0 * x

    @internal(**(OPTIONS | {"cache": False}))
    def chosen(x):
        if x is None:
            return of_none(1.0)
        return of_value(x)

    python = callable_from_python(chosen)
    assert python(1.5) == 4.5
    assert not of_none.overloads
    assert python(None) == 2.0
    assert len(of_none.overloads) == len(of_value.overloads) == 1


def test_another_numba_compiles_as_usual(monkeypatch):
    monkeypatch.setattr(deferred_code, "UNDOCUMENTED", ("a_method_that_does_not_exist",))

    @internal(**(OPTIONS | {"cache": False}))
    def triple(x):
        return 3.0 * x

    assert callable_from_python(triple)(1.5) == 4.5
    (compiled,) = triple.overloads.values()
    assert not isinstance(compiled.library, deferred_code.DeferredLibrary)
