"""Functions that are compiled with and without a wrapper for Python."""

import pytest
from kernel_call import callable_from_python

from hertzchain.kernels.compilation import OPTIONS, internal


@internal(**(OPTIONS | {"cache": False}))
def double(x):
    return 2.0 * x


def test_functions_of_kernels_cannot_be_called_by_mistake():
    with pytest.raises(TypeError, match="double has no wrapper for Python; call it from"):
        double(1.5)
    assert callable_from_python(double)(1.5) == 3.0
