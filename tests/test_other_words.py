"""Names that the package does not have lead to those that it has."""

import traceback
from pathlib import Path
from types import ModuleType

import pytest

import hertzchain as hc


@pytest.mark.parametrize(
    ("name", "meant"),
    [("materials", "catalogue"), ("tapered_chain", "Chain.tapered"), ("load_trace", "load_traces"),
     ("Soliton", "solitary_wave"), ("steady_rates", "theory.steady_rates"),
     ("modes", "spectrum"), ("reflection", "simulate(chain).reflection"),
     ("reproduce", "paper.reproduce"), ("Plot_Run", "plotting.plot_run")],
)  # fmt: skip
def test_unknown_names_have_one_suggestion(name, meant):
    with pytest.raises(AttributeError) as caught:
        getattr(hc, name)
    # Python adds suggestions when it prints the error.
    (line,) = traceback.format_exception_only(caught.value)
    assert line.strip() == (
        f"AttributeError: module 'hertzchain' has no attribute {name!r}; did you mean {meant!r}?"
    )


def test_names_without_any_likeness_have_none():
    with pytest.raises(AttributeError, match=r"has no attribute 'zzz'$"):
        hc.zzz  # noqa: B018


def test_words_that_lead_to_functions_are_not_names_of_modules():
    package = Path(hc.__file__).parent
    modules = {path.stem for path in package.iterdir() if not path.stem.startswith("_")}
    assert "derivatives" in modules
    assert not modules & hc._OTHER_WORDS.keys()
    public = {name for name in hc.__all__ if isinstance(getattr(hc, name), ModuleType)}
    assert modules & set(hc.__all__) <= public
    hc.gradient(hc.Chain.uniform(5), "pulse.velocity@3", to=["radii"])
    with pytest.raises(AttributeError, match="did you mean 'gradient'"):
        hc.sensitivity  # noqa: B018


def test_unknown_materials_are_one_sentence():
    with pytest.raises(hc.InputError, match=r"'steel' \(did you mean [^?]*\?\): choose") as caught:
        hc.material("steel")
    assert str(caught.value).count("did you mean") == 1
    assert "or define a custom one" in str(caught.value)


def test_a_width_of_figures_is_checked_at_once():
    with pytest.raises(hc.InputError, match="width must be 'single column' or"):
        hc.figure_style("three column")


def test_attributes_of_runs_have_one_suggestion(monkeypatch):
    run = hc.simulate(hc.Chain.uniform(3))
    for item, name, said in (
        (run, "peak", "; use pulse().peak_force at each contact, sensor_force(bead) or wall_f"),
        (run, "wallforce", "; did you mean 'wall_force'?"),
        (run, "zzz", ""),
    ):
        with pytest.raises(AttributeError) as caught:
            getattr(item, name)
        (line,) = traceback.format_exception_only(caught.value)
        told = f"AttributeError: {type(item).__name__!r} object has no attribute {name!r}{said}"
        assert line.startswith(told)
        assert line.count("did you mean") <= 1
    assert "Did you mean" not in line
    # A property with an error of its own keeps it.
    monkeypatch.setattr(hc.Run, "broken", property(lambda _: [].missing), raising=False)
    with pytest.raises(AttributeError, match="'list' object has no attribute 'missing'"):
        _ = run.broken
