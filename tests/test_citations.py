"""The bibliography is complete, and its BibTeX entries are valid."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import hertzchain as hc
from hertzchain.citations import bibtex, text, topics

ROOT = Path(__file__).parents[1]
REFERENCES = [each for references in topics().values() for each in references]
REQUIRED = {
    "article": {"author", "title", "journal", "volume", "pages", "year"},
    "book": {"author", "title", "publisher", "year"},
    "misc": {"author", "title"},
}


def parsed(source):
    """Entries of a BibTeX file: kind and fields by key; braces must match."""
    found, rest = {}, source
    while rest := rest.strip():
        head = re.match(r"@(\w+)\{(\w+),\n", rest)
        rest, fields = rest[head.end() :], {}
        while not rest.startswith("}"):
            name = re.match(r"  (\w+) = \{", rest)
            start = place = name.end()
            depth = 1
            while depth:
                depth += {"{": 1, "}": -1}.get(rest[place], 0)
                place += 1
            assert name[1] not in fields
            fields[name[1]] = rest[start : place - 1]
            rest = rest[place:].removeprefix(",\n")
        assert head[2] not in found
        found[head[2]], rest = (head[1], fields), rest[1:]
    return found


def test_bibtex_entries_are_valid():
    entries = parsed(bibtex())
    assert entries.keys() == {each.key for each in REFERENCES} | {"hertzchain"}
    assert bibtex().isascii()
    for kind, fields in entries.values():
        assert REQUIRED[kind] <= fields.keys()
        assert all(fields.values())
    assert entries["Hascoet2000"][1]["author"] == r"E. Hasco{\"e}t and H. J. Herrmann"
    assert entries["Dormand1987"][1]["title"].endswith(r"{Runge}-{Kutta}-{Nystr{\"o}m} formulae")
    assert entries["Tsuji1992"][1]["doi"] == "10.1016/0032-5910(92)88030-L"
    assert hc.__version__ in entries["hertzchain"][1]["note"]


@pytest.mark.parametrize("reference", REFERENCES, ids=lambda each: each.key)
def test_references_are_consistent(reference):
    assert reference.key.rstrip("ab").endswith(str(reference.year))
    assert re.fullmatch(r"|10\.\d{4,}/\S+", reference.doi)
    assert re.fullmatch(r"|(cond-mat/)?\d{7}|\d{4}\.\d{4,5}", reference.arxiv)
    if reference.law:
        assert hasattr(hc, reference.law)


def test_every_cited_source_is_in_the_bibliography():
    listed = " ".join(text().split())
    pages = [*ROOT.glob("docs/*/*.md"), *ROOT.glob("docs/examples/*.py"),
             *ROOT.glob("src/hertzchain/**/*.py"), ROOT / "README.md"]  # fmt: skip
    cited = set()
    for page in pages:
        for name in re.findall(
            r"(?:doi\.org/|arxiv\.org/abs/|doi:(?=10\.)|arXiv:)([\w./()-]*\d[\w/()-]*)",
            page.read_text("utf-8"),
        ):
            # A link ends with a parenthesis that is not part of the name.
            cited.add(name if name.count("(") == name.count(")") else name.rstrip(")"))
    assert len(cited) > 30
    assert not [name for name in sorted(cited) if name not in listed]


def test_the_page_lists_and_links_every_reference(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    from bibliography import bibliography_page

    page = bibliography_page()
    for each in REFERENCES:
        assert each.title in page
        assert f"arxiv.org/abs/{each.arxiv}" in page
    assert "https://doi.org/10.1016/0032-5910%2892%2988030-L)" in page


def test_the_command_prints_text_and_bibtex(run):
    assert run("cite").stdout == text() + "\n"
    assert run("cite", "--bibtex").stdout == bibtex() + "\n"
    # Names have accents, which a terminal in another encoding must not reject.
    command = [sys.executable, "-m", "hertzchain", "cite"]
    with_ascii = {"PYTHONIOENCODING": "ascii", "PYTHONPATH": str(ROOT / "src")}
    found = subprocess.run(command, capture_output=True, env=with_ascii, check=False)
    assert found.returncode == 0, found.stderr


def test_the_entry_of_the_software_is_that_of_the_citation_file_and_comes_first():
    source = (ROOT / "CITATION.cff").read_text("utf-8")
    known = dict(
        re.findall(r'(?m)^(?:  - )?(\w+): "?([^"\n]+)"?$', source.partition("references:")[0])
    )
    entry = f"{known['name']}, {known['title']}, version {known['version']}, {known['type']}."
    assert text().startswith(f"This software:\n  {entry}\n\nThe paper:\n")
    assert [*parsed(bibtex())][:2] == ["hertzchain", REFERENCES[0].key]
