"""Count code and docstring lines, long functions and long files of the package."""

import ast
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "hertzchain"
MAX_FUNCTION, MAX_FILE, MAX_RATIO = 60, 450, 0.45
# Longer functions and files, and why they are not split.
EXCEPTIONS = {
    "kernels/adjoint_window.py: follow": (
        "the loop over steps of a window, whose bounds and next step follow from the same events"
    ),
    "kernels/elastic_chains.py: follow": (
        "the loop over steps of eight chains, whose lanes are refilled from one list"
    ),
    "kernels/full_chain.py: advance": (
        "the loop over windows, whose bounds, records and numbers of steps change together"
    ),
    "kernels/full_chain.py: advance_window": (
        "the loop over steps: as separate functions, its parts would each receive all arrays of "
        "the state, and calls of compiled functions with many arrays take time"
    ),
    "kernels/symplectic.py: advance": (
        "the loop over steps, between stops for events, saved times and checks of the energy"
    ),
}
DEFINITIONS = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def docstring_span(node):
    """First and last line of a docstring, or None."""
    if isinstance(node, DEFINITIONS | ast.Module) and ast.get_docstring(node) is not None:
        return node.body[0].lineno, node.body[0].end_lineno
    return None


def code_lines(text, docstrings):
    """Lines that are neither blank nor comments, and not in docstrings."""
    lines = enumerate(map(str.strip, text.splitlines()), start=1)
    return {at for at, line in lines if line and line[0] != "#"} - docstrings


def count():
    """Numbers of code and docstring lines, and what is too long, by name with its length."""
    code = documentation = 0
    too_long = {}
    for path in sorted(SOURCE.rglob("*.py")):
        text, name = path.read_text("utf-8"), path.relative_to(SOURCE)
        docstrings = set()
        for node in ast.walk(ast.parse(text)):
            span = docstring_span(node)
            if span:
                docstrings.update(range(span[0], span[1] + 1))
            if isinstance(node, ast.FunctionDef):
                length = node.end_lineno - node.lineno + 1
                length -= span[1] - span[0] + 1 if span else 0
                if length > MAX_FUNCTION:
                    too_long[f"{name.as_posix()}: {node.name}"] = length
        code += len(code_lines(text, docstrings))
        documentation += len(docstrings)
        if text.count("\n") > MAX_FILE:
            too_long[name.as_posix()] = text.count("\n")
    return code, documentation, too_long


def main():
    """Print the counts."""
    code, documentation, too_long = count()
    print(f"{code} code lines, {documentation} docstring lines, ratio {documentation / code:.2f}")
    print(f"functions longer than {MAX_FUNCTION} lines and files longer than {MAX_FILE}:")
    for name, length in too_long.items():
        print(f"  {name}, {length}: {EXCEPTIONS.get(name, 'split it')}")


if __name__ == "__main__":
    main()
