"""Count code and docstring lines, long functions and long files of the package."""

import ast
import io
import tokenize
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "hertzchain"
MAX_FUNCTION, MAX_FILE = 60, 450
DEFINITIONS = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def docstring_span(node):
    """First and last line of a docstring, or None."""
    if isinstance(node, DEFINITIONS | ast.Module) and ast.get_docstring(node) is not None:
        return node.body[0].lineno, node.body[0].end_lineno
    return None


def code_lines(text, docstrings):
    """Lines that hold a token other than comments and docstrings."""
    found = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT,
                              tokenize.DEDENT, tokenize.ENDMARKER):  # fmt: skip
            found.update(range(token.start[0], token.end[0] + 1))
    return found - docstrings


def main():
    """Print the counts."""
    code = documentation = 0
    long_functions, long_files = [], []
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
                    long_functions.append(f"{name}: {node.name}, {length}")
        code += len(code_lines(text, docstrings))
        documentation += len(docstrings)
        if text.count("\n") > MAX_FILE:
            long_files.append(f"{name}, {text.count(chr(10))}")
    print(f"{code} code lines, {documentation} docstring lines, ratio {documentation / code:.2f}")
    print(f"functions longer than {MAX_FUNCTION} lines:", *long_functions, sep="\n  ")
    print(f"files longer than {MAX_FILE} lines:", *long_files, sep="\n  ")


if __name__ == "__main__":
    main()
