import dataclasses
import json
import warnings

import numpy as np
import pytest
from click.testing import CliRunner

import hertzchain as hc
from hertzchain.cli import cli
from hertzchain.evaluation import percentage
from hertzchain.evaluation.cases import FREE_END, GROUPS, Case, paper_cases, unseen_cases
from hertzchain.evaluation.evaluate import evaluate, scoreboard
from hertzchain.evaluation.scoreboard import QUANTITIES
from hertzchain.evaluation.unseen_tapers import (
    bump,
    hourglass,
    is_smooth,
    piecewise_exponential,
    power_law,
    random_smooth,
    scatter,
    sigmoid,
    step,
    unseen_radii,
    wave,
)
from hertzchain.plotting.scoreboard import plot_scoreboard
from hertzchain.sweeps.methods import METHODS
from hertzchain.theory.catalogue import THEORIES
from hertzchain.theory.modified_bca import two_thirds_bca


@pytest.fixture(scope="module")
def board():
    return scoreboard()


def case_of(radii, name="chain", family="family", group="smooth"):
    return Case(name, family, group, hc.Chain.from_radii(radii))


def off_by(factors):
    """A theory that is the BCA with its velocities times given factors."""

    def theory(chain):
        pulse = hc.bca(chain)
        return dataclasses.replace(pulse, velocity=pulse.velocity * factors)

    return theory


def test_errors_of_a_theory_that_is_wrong_by_known_amounts():
    case = case_of(np.ones(20))
    factors = np.ones(20)
    factors[[1, 11]] = 1.3, 1.1
    # Past the last bead that counts.
    factors[-FREE_END:] = 5.0
    board = evaluate([case], [hc.bca(case.chain)], {"wrong": off_by(factors)})
    assert board.worst("velocity", first_bead=2) == pytest.approx(0.3, rel=1e-12)
    assert board.worst("velocity", first_bead=10) == pytest.approx(0.1, rel=1e-12)
    assert board.worst("energy", first_bead=10) == pytest.approx(0.21, rel=1e-12)
    # Beads 10..17 hold one error of a tenth.
    assert board.rms("velocity", first_bead=10) == pytest.approx(0.1 / 8**0.5, rel=1e-12)
    assert board.worst("arrival", first_bead=2) == 0.0


def test_coverage_is_that_of_all_groups_by_default():
    cases = [case_of(np.ones(20)), case_of(np.ones(24), "b", "other", "rough")]
    exact = [hc.bca(case.chain) for case in cases]

    def theory(chain):
        # The error is 10% at each bead; the estimate covers it only in the shorter chain.
        pulse = off_by(1.1)(chain)
        estimate = 0.2 if chain.beads == 20 else 0.05
        return dataclasses.replace(pulse, velocity_error=np.full(chain.beads, estimate))

    board = evaluate(cases, exact, {"known": theory, "bca": hc.bca})
    # Beads 2..17 and 2..21.
    assert board.coverage("known")[0] == pytest.approx(16 / 36)
    assert board.coverage("known", "smooth") == pytest.approx((1.0, 2.0))
    assert board.coverage("known", "rough") == pytest.approx((0.0, 0.5))
    with pytest.raises(hc.InputError, match="bca does not .* on the chains of smooth and rough$"):
        board.coverage("bca")
    with pytest.raises(hc.InputError, match="does not estimate its error on the chains of rough$"):
        board.coverage("bca", "rough")


def test_a_family_gathers_its_chains():
    cases = [case_of(np.ones(20), "a"), case_of(np.ones(24), "b")]
    exact = [hc.bca(case.chain) for case in cases]

    def theory(chain):
        return off_by(np.full(chain.beads, 1.1 if chain.beads == 20 else 1.3))(chain)

    board = evaluate(cases, exact, {"wrong": theory})
    assert board.table("velocity").loc["family", "wrong"] == pytest.approx(0.3)
    rms = board.table("velocity", statistic="rms").loc["family", "wrong"]
    assert rms == pytest.approx(((0.1**2 + 0.3**2) / 2) ** 0.5)
    assert list(board.table("velocity", by="case").index) == ["a", "b"]


def test_one_chain_that_is_rejected_makes_its_family_a_dash():
    cases = [case_of(np.ones(20), "a"), case_of(np.ones(24), "b")]

    def theory(chain):
        if chain.beads == 24:
            raise hc.InputError("24 beads are too many")
        return hc.bca(chain)

    board = evaluate(cases, [hc.bca(case.chain) for case in cases], {"picky": theory})
    assert np.isnan(board.table("velocity").loc["family", "picky"])
    assert board.table("velocity", by="case").loc["a", "picky"] == 0.0
    assert board.refusals == {("picky", "b"): "24 beads are too many"}
    entry = board.as_dict()["rows"][1]["theories"]["picky"]
    assert entry == board.as_dict("family")["rows"][0]["theories"]["picky"]
    assert entry == {"warned": False, "errors": {}, "refusal": "24 beads are too many"}


def test_what_a_theory_warns_of_is_noted_and_other_warnings_go_on():
    case = case_of(np.ones(20))

    def theory(chain):
        warnings.warn("beyond me", hc.ModelRangeWarning, stacklevel=2)
        warnings.warn("old", DeprecationWarning, stacklevel=2)
        return hc.bca(chain)

    with pytest.warns(DeprecationWarning, match="old") as caught:
        board = evaluate([case], [hc.bca(case.chain)], {"shy": theory})
    assert [item.category for item in caught] == [DeprecationWarning]
    assert board.warned.all()
    assert board.outside().loc["family", "shy"]


def test_only_what_a_theory_predicts_has_a_number(board):
    covered = {
        name: {q for q in QUANTITIES if not board.table(q)[name].iloc[0:1].isna().any()}
        for name in board.theories
    }
    velocity_alone = {"velocity", "momentum", "energy"}
    assert covered["bca"] == set(QUANTITIES)
    assert covered["hard-sphere"] == velocity_alone
    assert covered["modified-bca"] == velocity_alone
    unseen = board.table("velocity", by="group").loc[["smooth", "rough"]]
    assert unseen[["modified-bca", "modified-bca-printed"]].isna().all(axis=None)
    assert not unseen[["bca", "two-thirds-bca"]].isna().any(axis=None)


def test_known_errors(board):
    worst = board.table("velocity", by="case", first_bead=10)
    equal_beads = 1.0 / 0.681631548571 - 1.0
    # Nearly equal beads: the BCA keeps velocity one.
    assert worst.loc["forward-linear, S = 0.001", "bca"] == pytest.approx(equal_beads, rel=0.03)
    # The paper's misprints: forward linear velocities vanish where they should grow.
    assert worst.loc["forward-linear, S = 0.009", "modified-bca-printed"] > 0.9
    assert worst.loc["backward-exponential, q = 0.05", "modified-bca"] < 0.01
    assert board.worst("momentum") == pytest.approx(board.worst("velocity"), nan_ok=True)


def test_outside_is_where_the_rates_were_not_fitted(board):
    outside = board.outside("group")
    assert outside.loc["beyond", "modified-bca"]
    assert not outside.loc["paper"].any()
    assert not outside["bca"].any()


def longer(case):
    """The same taper, a few beads longer where it has radius left."""
    if case.chain.taper is None:
        return unseen_radii(110)[case.name]
    beads = 105 if case.chain.taper == "forward-linear" else 110
    return hc.Chain.tapered(case.chain.taper, case.chain.rate, beads=beads)


def test_the_free_end_is_not_felt_where_errors_count():
    cases = [*paper_cases(), *unseen_cases()]
    as_judged = hc.propagate_many([case.chain for case in cases])
    without_end = hc.propagate_many([longer(case) for case in cases])
    for case, ours, theirs in zip(cases, as_judged, without_end, strict=True):
        for quantity in QUANTITIES:
            counted = ours.column(quantity)[: case.last_bead]
            # Measured: 6e-10, of the force in the strongest forward taper.
            np.testing.assert_allclose(
                counted, theirs.column(quantity)[: case.last_bead], rtol=1e-9, err_msg=case.name
            )


def test_most_unseen_tapers_are_smooth_and_the_groups_say_so():
    cases = unseen_cases()
    smooth = [case for case in cases if case.group == "smooth"]
    assert len(cases) >= 10
    assert len(cases) / 2 < len(smooth) < len(cases)
    for case in cases:
        rates = np.diff(np.log(case.chain.radii))
        gentle = np.abs(rates).max() <= 0.1 and np.abs(np.diff(rates)).max() <= 0.005
        assert gentle == (case.group == "smooth") == is_smooth(case.chain.radii)


def test_no_unseen_taper_is_one_that_theories_are_fitted_to():
    for name, radii in unseen_radii().items():
        rates = np.diff(np.log(radii))
        assert np.ptp(rates) > 1e-3, f"{name} is an exponential"
        assert np.ptp(np.diff(rates)) > 1e-4, f"{name} is a ramp"
        steps = np.diff(radii / radii[0])
        assert np.ptp(steps) > 1e-3 * np.abs(steps).max(), f"{name} is linear"


def test_unseen_tapers_are_the_same_every_time():
    first, second = unseen_radii(), unseen_radii()
    for name, radii in first.items():
        np.testing.assert_array_equal(radii, second[name])


def test_the_paper_is_covered_at_its_rates_and_beyond():
    names = {case.name for case in paper_cases()}
    assert {"backward-exponential, q = 0.3", "forward-exponential, q = 0.12",
            "backward-linear, S = 1", "forward-linear, S = 0.0095"} <= names  # fmt: skip
    assert len(names) == len(paper_cases()) == 32


def test_two_thirds():
    chain = hc.Chain.tapered("backward-linear", 0.5, beads=40)
    np.testing.assert_allclose(
        two_thirds_bca(chain).velocity[1:], hc.bca(chain).velocity[1:] * 2 / 3, rtol=1e-15
    )
    assert two_thirds_bca(chain).arrival is None


def test_the_command_line_supports_every_theory():
    assert set(METHODS) == {"propagate", "simulate", *THEORIES, "piecewise-local-rate"}


def test_xarray_holds_the_same(board):
    data = board.to_xarray()
    there = data.velocity.sel(theory="bca", case="waist", bead=slice(10, None))
    t, c = board.theories.index("bca"), [case.name for case in board.cases].index("waist")
    assert float(abs(there).max()) == board.worst("velocity")[t, c]
    assert set(data.group.values) == {"paper", "beyond", "smooth", "rough"}


def test_json_is_finite(board):
    document = json.loads(json.dumps(board.as_dict(), allow_nan=False))
    assert len(document["rows"]) == 52
    errors = document["rows"][0]["theories"]["bca"]["errors"]["velocity"]
    assert errors["from_10"]["rms"] < errors["from_10"]["worst"] <= errors["from_2"]["worst"]


def test_dataframe_holds_the_same(board):
    rows = board.to_dataframe().set_index(["theory", "case", "quantity", "first_bead"])
    table = board.table("energy", first_bead=2, statistic="rms", by="case")
    assert rows.loc[("bca", "waist", "energy", 2), "rms"] == table.loc["waist", "bca"]
    assert len(rows) == len(board.theories) * len(board.cases) * len(QUANTITIES) * 2


def test_text_and_view_have_the_table_of_the_command_line(board):
    shown = CliRunner().invoke(cli, ["scoreboard"]).output
    rows = {line for line in shown.splitlines() if line.startswith(" ") and "." in line}
    words = {" ".join(line.split()) for line in rows}
    found = {" ".join(line.split()) for line in str(board).splitlines()}
    assert len(words) > 20
    assert words <= found
    assert max(map(len, str(board).splitlines())) <= 88
    for text in (*GROUPS.values(), *board.theories, "2652<", "50*<"):
        assert text in board._repr_html_().replace("&#x27;", "'")


def test_percentages_have_two_digits():
    errors = (0.0, 1.0, 0.0995, 0.00995, 26.5, float("nan"))
    assert [percentage(error) for error in errors] == ["0", "100", "10", "1.0", "2650", "–"]


def test_the_figure_has_a_symbol_for_every_number(board):
    axes = plot_scoreboard(board, "peak_force", first_bead=2)
    table = board.table("peak_force", first_bead=2)
    drawn = np.concatenate([line.get_xdata() for line in axes.lines])
    wanted = 100.0 * table.to_numpy()
    assert sorted(drawn[~np.isnan(drawn)]) == sorted(wanted[~np.isnan(wanted)])
    assert len(axes.get_yticks()) == len(table)
    assert "k = 2" in axes.get_xlabel()
    # Theories without any number are not named.
    (legend,) = axes.figure.legends
    named = [text.get_text() for text in legend.get_texts()]
    assert named == ["BCA", "local-rate law", "pale: outside the range"]
    velocity = plot_scoreboard(board)
    pale = [len(line.get_xdata()) for line in velocity.lines if line.get_alpha() == 0.35]
    table = board.table("velocity")
    warned = (board.outside() & table.notna()).to_numpy().sum(axis=0)
    # Two theories warn for the four families beyond the rates, the law for rough tapers.
    assert sorted(warned)[-3:-1] == [4, 4]
    assert sum(pale) == sum(warned)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda _: scoreboard(theories=["bac"]), "did you mean 'bca'"),
        (lambda _: scoreboard(theories=[]), "theories must be a list"),
        (lambda _: scoreboard(theories="bca"), "theories must be a list of names"),
        (lambda board: board.worst("speed"), "unknown quantity of the scoreboard"),
        (lambda board: board.worst("velocity", first_bead=1), "a whole number from 2 to 97"),
        (lambda board: board.table("velocity", first_bead=98), "a whole number from 2 to 97"),
        (lambda board: board.table("velocity", statistic="mean"), "unknown statistic"),
        (lambda board: board.table("velocity", by="taper"), "unknown row"),
        (lambda _: evaluate([], []), "at least one chain"),
        (lambda _: case_of(np.ones(12)), "at least 13"),
        (lambda _: case_of(np.ones(20), group="seen"), "unknown group"),
        (lambda _: evaluate([case_of(np.ones(20))], [hc.bca(hc.Chain.uniform(21))]), "different"),
    ],
)  # fmt: skip
def test_bad_input_is_rejected(board, call, said):
    with pytest.raises(hc.InputError, match=said):
        call(board)


def test_families_of_unseen_tapers():
    k = np.array([50.0, 51.0])
    rates = np.diff(np.log(piecewise_exponential(np.arange(1.0, 53.0), (0.05, 0.0, 0.1))))
    np.testing.assert_allclose(rates[[0, 23, 24, 49, 50]], [0.05, 0.05, 0.05, 0.0, 0.1], atol=1e-14)
    assert power_law(k, 2.0, 50.0)[0] == 1e4
    assert sigmoid(k, 3.0, 10.0)[0] == 2.0
    assert bump(k, -0.4, 18.0)[0] == pytest.approx(0.6, rel=1e-15)
    assert wave(np.array([15.0]), 0.2, 60.0, 0.1)[0] == pytest.approx(1.2 * np.exp(1.5), rel=1e-15)
    assert hourglass(np.array([75.0]), 25.0)[0] == pytest.approx(np.cosh(1.0), rel=1e-15)
    assert step(k, 1.3).tolist() == [1.0, 1.3]
    assert scatter(k, 0.0, seed=1).tolist() == [1.0, 1.0]
    assert is_smooth(random_smooth(np.arange(1.0, 101.0), seed=7))


def test_a_scoreboard_is_not_plotted_into_a_number():
    board = scoreboard(theories=["hard-sphere"])
    with pytest.raises(hc.InputError, match=r"ax must be .*Axes.*, got 3"):
        plot_scoreboard(board, ax=3)
