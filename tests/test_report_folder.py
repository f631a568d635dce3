"""The folder of a report: nothing in it is lost that hertzchain did not write."""

import json

import pytest

import hertzchain as hc
from hertzchain.paper.report import write_report, write_reserved
from hertzchain.paper.report_folder import MANIFEST, replaced_report, reserved
from hertzchain.paper.reproduction import reproduce


def files(folder):
    """Content of all files, by path."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != ".lock"
    }


def figures(folder):
    return {path.stem for path in (folder / "figures").iterdir()}


def test_an_unwritable_folder_is_named(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    with pytest.raises(hc.InputError, match="cannot write .*file"):
        write_report(reproduce(["table3"]), tmp_path / "file")


def test_two_reports_into_one_folder_are_kept_apart(tmp_path):
    with (
        reserved(tmp_path),
        pytest.raises(hc.InputError, match="another process is writing to"),
    ):
        write_report(reproduce(["table3"]), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".lock"]


def test_what_killed_reports_left_is_removed_and_nothing_else(tmp_path):
    write_report(reproduce(["table3"]), tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    left, mine = tmp_path / ".writing-ab_c3xyz", tmp_path / ".writing-about"
    also_mine = tmp_path / ".writing-abcdefgh"
    for folder in (left, mine, also_mine):
        (folder / "figures").mkdir(parents=True)
        (folder / "figures" / "figure6.svg").touch()
    (left / "report.html").touch()
    (also_mine / "figures" / "thesis.svg").touch()
    with reserved(tmp_path):
        pass
    assert {path.name for path in tmp_path.iterdir()} == {*before, mine.name, also_mine.name}
    assert (also_mine / "figures" / "thesis.svg").exists()


def test_a_folder_in_which_a_process_was_killed_before_its_first_report_is_accepted(tmp_path):
    (tmp_path / ".writing-ab_c3xyz" / "figures").mkdir(parents=True)
    (tmp_path / ".writing-ab_c3xyz" / MANIFEST).touch()
    (tmp_path / ".lock").touch()
    assert write_report(reproduce(["table3"]), tmp_path).exists()


@pytest.mark.long
def test_figures_of_other_parts_are_kept_and_named(tmp_path):
    write_report(reproduce(["figure6", "figure11", "table3"]), tmp_path)
    before = files(tmp_path)
    assert "earlier reproductions" not in before["summary.md"].decode()
    said = replaced_report(tmp_path, ["figure6"])
    assert "also contained table3 and figure11; its figures are kept in" in said
    write_report(reproduce(["figure6"]), tmp_path)
    after = files(tmp_path)
    assert after.keys() == before.keys()
    for name in before:
        if name.startswith("figures/"):
            assert after[name] == before[name]
    assert list(json.loads(after["verdict.json"])["figures"]) == ["figure6"]
    for page in ("summary.md", "report.html"):
        text = after[page].decode().replace("\n", " ")
        assert "also contains figure11 of earlier reproductions" in text
    # The report of all parts describes all figures again.
    write_report(reproduce(["figure6", "figure11", "table3"]), tmp_path)
    assert "earlier reproductions" not in (tmp_path / "summary.md").read_text("utf-8")
    assert replaced_report(tmp_path, ["figure6", "figure11", "table3"]) == ""


@pytest.mark.long
@pytest.mark.parametrize("name", ["report.html", "summary.md", "figures/figure6.svg"])
def test_a_changed_file_is_not_replaced(tmp_path, name):
    result = reproduce(["figure6"])
    write_report(result, tmp_path)
    (tmp_path / name).write_text("mine")
    before = files(tmp_path)
    with pytest.raises(hc.InputError, match=rf"{name}' was not written by hertzchain or has been"):
        write_report(result, tmp_path)
    assert files(tmp_path) == before
    (tmp_path / name).rename(tmp_path / "mine")
    write_report(result, tmp_path)
    assert (tmp_path / "mine").read_text() == "mine"


def test_a_changed_figure_that_is_not_replaced_is_no_obstacle(tmp_path):
    write_report(reproduce(["figure6", "table3"]), tmp_path)
    (tmp_path / "figures" / "figure6.svg").write_text("mine")
    (tmp_path / "figures" / "thesis.png").write_text("mine, too")
    write_report(reproduce(["table3"]), tmp_path)
    assert (tmp_path / "figures" / "figure6.svg").read_text() == "mine"
    assert (tmp_path / "figures" / "thesis.png").read_text() == "mine, too"


def test_a_file_that_appears_while_the_report_is_computed_is_not_replaced(tmp_path):
    result = reproduce(["table3"])
    with reserved(tmp_path, result.parts):
        (tmp_path / "report.html").write_text("mine")
        with pytest.raises(hc.InputError, match=r"report\.html' was not written"):
            write_reserved(result, tmp_path)
    assert files(tmp_path) == {"report.html": b"mine"}


@pytest.mark.parametrize("name", ["report.html", "notes.txt", "figures"])
def test_a_folder_of_others_is_refused_before_anything_is_computed(run, tmp_path, name):
    other = tmp_path / "other"
    other.mkdir()
    if name == "figures":
        (other / name).mkdir()
    else:
        (other / name).write_text("mine")
    code, out, err = run("reproduce", "--only", "table3", "--out", other)
    assert (code, out) == (2, "")
    assert f"contains '{name}' and was not written by" in err
    assert [path.name for path in other.iterdir()] == [name]


def test_a_folder_is_used_again_from_the_command_line(run, tmp_path):
    folder = tmp_path / "check"
    _, _, err = run("reproduce", "--only", "table1,figure6", "--out", folder)
    assert "replaces" not in err
    code, out, err = run("reproduce", "--only", "table3", "--out", folder)
    assert code == 0
    assert err.endswith(
        "The report replaces an earlier one that also contained table1 and figure6; its figures "
        f"are kept in {folder / 'figures'}.\n"
    )
    assert figures(folder) == {"figure6"}
    (folder / "figures" / "figure6.svg").write_text("mine")
    code, out, err = run("reproduce", "--only", "figure6", "--out", folder)
    assert (code, out) == (2, "")
    assert "figure6.svg' was not written by hertzchain or has been changed since" in err


def test_a_process_killed_while_it_moves_files_leaves_a_folder_that_can_be_used(
    tmp_path, monkeypatch
):
    write_report(reproduce(["table3"]), tmp_path)
    before = files(tmp_path)
    with monkeypatch.context() as patched:
        moved = []

        def dies(source, target):
            if target.name == "summary.md":
                raise KeyboardInterrupt
            moved.append(target.name)
            return original(source, target)

        original = type(tmp_path).replace
        patched.setattr(type(tmp_path), "replace", dies)
        with pytest.raises(KeyboardInterrupt):
            write_report(reproduce(["table1"]), tmp_path)
    assert moved == [MANIFEST, "report.html", "verdict.json"]
    assert files(tmp_path)["report.html"] != before["report.html"]
    assert files(tmp_path)["summary.md"] == before["summary.md"]
    write_report(reproduce(["table3"]), tmp_path)
    assert "Table 3" in (tmp_path / "summary.md").read_text("utf-8")


@pytest.mark.parametrize("content", ["", "{}", '{"files": []}', '{"files": {}, "parts": 3}'])
def test_a_damaged_manifest_is_named(tmp_path, content):
    (tmp_path / MANIFEST).write_text(content)
    with pytest.raises(hc.InputError, match="is damaged, so it is unknown"):
        write_report(reproduce(["table3"]), tmp_path)
    assert list(files(tmp_path)) == [MANIFEST]
