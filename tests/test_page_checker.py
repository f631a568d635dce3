"""The checker of built pages finds broken links, images without a text and loaded files."""

import check_pages
import pytest

GOOD = '<h1 id="top">A</h1><a href="b.html#top">b</a><img src="a.png" alt="A chain.">'


def problems(folder, page):
    (folder / "a.html").write_text(page)
    (folder / "b.html").write_text(GOOD)
    return list(check_pages.check_files(folder))


def test_good_pages_have_no_problems(tmp_path):
    assert (
        problems(tmp_path, GOOD + '<a href="https://example.org">x</a><a href="#top">y</a>') == []
    )
    assert check_pages.main([str(tmp_path)]) == 0


@pytest.mark.parametrize(
    ("page", "problem"),
    [
        ('<a href="c.html">', "a.html: link to c.html, which does not exist"),
        ('<a href="b.html#end">', "a.html: link to b.html#end, but there is no such anchor"),
        ('<a href="#end">', "a.html: link to #end, but there is no such anchor"),
        ('<img src="a.png">', "a.html: image a.png has no alternative text"),
        ('<img src="a.png" alt="">', "a.html: image a.png has no alternative text"),
        ('<img src="a.png" alt="Figure">', "a.html: image a.png has no alternative text"),
        ("<em>radii: <span>_SupportsArray</span></em>",
         "a.html: a signature shows _SupportsArray"),
        ('<script src="https://cdn.org/x.js">',
         "a.html: https://cdn.org/x.js is loaded from another host"),
        ('<link rel="stylesheet" href="//cdn.org/x.css">',
         "a.html: //cdn.org/x.css is loaded from another host"),
    ],
)  # fmt: skip
def test_each_problem_is_found(tmp_path, page, problem):
    assert problems(tmp_path, page) == [problem]
    assert check_pages.main([str(tmp_path)]) == 1
