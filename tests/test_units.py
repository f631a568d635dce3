"""Text with units, compared with pint and with the decimal numbers that it means."""

import itertools
import random

import pint
import pytest

import hertzchain as hc
from hertzchain.units import SYMBOLS, UNITS, converted, quantity
from hertzchain.validation.numbers import number

PINT = pint.UnitRegistry()


def test_every_symbol_is_what_pint_says():
    for symbol, (factor, powers) in SYMBOLS.items():
        theirs = PINT.Quantity(1.0, symbol).to_base_units()
        expected = PINT.Quantity(float(factor)) * PINT.m ** powers[0] * PINT.kg ** powers[1]
        expected = expected * PINT.s ** powers[2]
        assert theirs.to(expected.units).magnitude == pytest.approx(expected.magnitude, rel=1e-15)


def test_products_of_units_are_what_pint_says():
    rng = random.Random(1)
    for _ in range(300):
        chosen = rng.choices(list(SYMBOLS), k=rng.randint(1, 4))
        powers = [rng.choice([1, 2, 3, 1.5, -1, -2, 0.5]) for _ in chosen]
        signs = [rng.choice("*/") for _ in chosen]
        text = chosen[0] + f"^{powers[0]}"
        theirs = f"{chosen[0]}**{powers[0]}"
        for symbol, power, sign in zip(chosen[1:], powers[1:], signs[1:], strict=True):
            text += f"{sign}{symbol}^{power}"
            theirs += f"{sign}{symbol}**({power})"
        base = PINT.Quantity(2.5, theirs).to_base_units()
        si = "*".join(
            f"{unit}**{base.dimensionality.get(name, 0.0):.6f}"
            for unit, name in (("m", "[length]"), ("kg", "[mass]"), ("s", "[time]"))
        )
        assert converted("x", "2.5", text, si) == pytest.approx(base.magnitude, rel=1e-12), text


def test_standard_gravity_is_a_unit_of_acceleration_and_g_is_the_gram():
    assert converted("a", "150", "g0", "m/s^2") == pytest.approx(1470.9975, rel=1e-15)
    with pytest.raises(hc.InputError, match=r"must have a unit such as .*, g0, got 'g'"):
        converted("a", "1", "g", "m/s^2")
    body = hc.Chain.from_materials("10 mm", "steel-52100", beads=3, velocity=0.1, gravity="1 g0")
    assert body.gravity == 9.80665
    limits = {"body_force.acceleration": "<= 150 g0"}
    row = body.replace(gravity=0.0).with_cap(mass="200 g")
    radii = hc.vary.radii("4 mm", "5 mm", beads="2:3")
    problem = hc.Design(row, minimise="length", vary=[radii], subject_to=limits)
    assert "body_force.acceleration <= 150 g0" in [str(each) for each in problem.requirements]


def test_units_that_are_offered_exist_and_are_of_one_dimension():
    for dimension, units in UNITS.items():
        for unit in units:
            assert converted(dimension, 1, unit, units[0]) > 0.0
        for other, names in UNITS.items():
            if other != dimension:
                with pytest.raises(hc.InputError, match="must have a unit such as"):
                    converted(dimension, 1, names[0], units[0])


def test_messages_offer_every_symbol_of_the_dimension():
    for symbol, (_, powers) in SYMBOLS.items():
        si = next(
            (each for each, (factor, own) in SYMBOLS.items() if own == powers and factor == "1"),
            "m/s^2",
        )
        with pytest.raises(hc.InputError, match=rf"choose from .*\b{symbol}\b"):
            converted("x", 1, "furlong", si)
    for unit in ("furlong", "kg"):
        with pytest.raises(hc.InputError, match="s, ms, us, µs, ns, min, h"):
            number("until", f"5 {unit}", unit="s")


def test_text_is_the_decimal_number_that_it_says():
    rng = random.Random(2)
    for _ in range(2000):
        digits = f"{rng.uniform(0.1, 1000):.{rng.randint(1, 14)}f}"
        assert number("radius", f"{digits} mm", unit="m") == float(f"{digits}e-3")
        assert number("gap", f"{digits}um", unit="m") == float(f"{digits}e-6")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5 mm", 5e-3), ("5mm", 5e-3), (" 5\u00b5m", 5e-6), ("5 \u03bcm", 5e-6), ("+1e3 nm", 1e-6),
        (".5 in", 0.0127), ("2 km", 2000.0), ("-3.cm", -0.03),
        ("3/16 in", 0.0047625), ("1 1/2 in", 0.0381), ("1-1/2in", 0.0381), (" 5 / 8 in ", 0.015875),
    ],
)  # fmt: skip
def test_ways_to_write_a_length(text, value):
    assert number("length", text, unit="m") == value


def test_minutes_are_accepted():
    assert number("budget", "60min", unit="s") == 3600.0
    with pytest.raises(hc.InputError, match="did you mean 'min'"):
        number("budget", "60 minutes", unit="s")


def test_ways_to_write_powers_and_products():
    for text in ("9.81 m/s^2", "9.81 m/s**2", "9.81 m/s²", "9.81 m s^-2", "9.81m/s/s"):
        assert number("gravity", text, unit="m/s**2") == 9.81
    assert number("density", "7.8 g/cm³", unit="kg/m**3") == 7800.0
    assert number("stiffness", "7 N/um^1.5", unit="N/m**1.5") == 7e9
    assert number("frequency", "2 1/ms", unit="Hz") == 2000.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("5", "gap is '5', without a unit; write '5 mm' or another unit"),
        ("9.81", "gap is '9.81', without a unit; write '9.81 mm'"),
        ("1e-3", "gap is '1e-3', without a unit; write '1e-3 mm'"),
        ("mm", "gap must be a number, or text with a unit such as '5 mm', got 'mm'"),
        ("0,05", "got '0,05'; write 0.05 with a decimal point$"),
        ("10,5 mm", "got '10,5 mm'; write 10.5 mm with a decimal point$"),
        ("10,5 m/s", "; write 10.5 with a decimal point and a unit such as m, cm, mm$"),
        ("1,2,3", "got '1,2,3'; write 1.2 with a decimal point$"),
        ("1.234,5 mm", "got '1.234,5 mm'$"),
        ("5 furlong", "unknown unit of gap 'furlong': choose from m, cm, mm"),
        ("5 kg", "gap must have a unit such as m, cm, mm.* got 'kg'"),
        ("20 mu", "unknown unit of gap 'mu'; did you mean 'um'"),
        ("5 mm/", "unknown unit"),
        ("5 mm^", "unknown unit"),
        ("5 m^1000", "unknown unit"),
        ("5 %", "gap must have a unit such as m, cm, mm.* got '%'"),
        ("1/0 in", "unknown unit"),
        ("3/16 mm", "unknown unit"),
        ("nan mm", "and finite, got 'nan mm'"),
        ("1e999 mm", "must be at least 0 and finite, got '1e999 mm'"),
        ("-1 mm", "must be at least 0, got '-1 mm'"),
    ],
)
def test_an_invalid_length_is_rejected(text, said):
    with pytest.raises(hc.InputError, match=said):
        number("gap", text, unit="m", least=0.0)


def test_ways_to_write_a_fraction():
    chain = hc.Chain.uniform(60)
    for call, expected in (
        (lambda x: chain.with_scatter(1, relative=x).radii[1], 0.01),
        (lambda x: hc.disorder(chain, x).velocity[50], 0.01),
        (lambda x: hc.Scatter(radius=x).radius, 0.01),
        (lambda x: hc.Restitution(x).coefficient, 0.95),
        (lambda x: hc.UnloadingRatio(x).ratio, 0.05),
        (lambda x: hc.WaltonBraun(x).ratio, 0.8),
        (lambda x: hc.bca(chain, restitution=x).velocity[1], 0.9),
        (lambda x: hc.Chain.tapered("forward-exponential", x, beads=4).radii[3], 0.05),
        (lambda x: hc.Chain.tapered(first=2.0, ratio=x, beads=4).radii[3], 0.25),
        (lambda x: hc.Chain.dimer(mass_ratio=x, beads=4).masses[1], 0.3),
        (lambda x: chain.decorated(x).radii[1], 0.3),
    ):
        assert call(f"{100 * expected:g}%") == call(f"{100 * expected:g} %") == call(expected)
        for wrong, said in (("5 mm", "no unit|number|got the length"),
                            ("1 foo", "plain number or a percentage"),
                            ("0.01", "give the number 0.01 without quotes")):  # fmt: skip
            with pytest.raises(hc.InputError, match=said):
                call(wrong)
    assert hc.Scatter(radius="1%").radius == 0.01
    with pytest.raises(hc.InputError, match=r"must not be a percentage, got '5%'; write 0.05"):
        hc.Chain.uniform(4, exponent="5%")
    with pytest.raises(hc.InputError, match=r"must not be a percentage"):
        hc.Chain.uniform(4).replace(gaps="5%")


def test_extreme_numbers_do_not_stop_a_conversion():
    for text, unit in itertools.product(("1e-290", "1e300", "0", "9" * 60), ("mm", "km")):
        assert converted("x", text, unit, "m") == pytest.approx(
            float(text) * float(SYMBOLS[unit][0]), rel=1e-15
        )
    assert quantity("1" * 200 + " mm") is None


@pytest.mark.parametrize(
    ("stiffness", "exponent", "said"),
    [
        ("2 kN/mm", 1.5, "got 'kN/mm'; contacts with this unit have exponent = 1$"),
        ("2 N/m^1.5", 1, "got 'N/m\\^1.5'; contacts with this unit have exponent = 1.5$"),
        ("2 N", None, "got 'N'$"),
        ("2 GPa", None, "got 'GPa'$"),
    ],
)
def test_stiffness_in_the_unit_of_another_exponent_advises_the_exponent(stiffness, exponent, said):
    with pytest.raises(hc.InputError, match=said):
        hc.Wall(stiffness, exponent=exponent)


@pytest.mark.parametrize(
    ("unit", "si", "hint"),
    [
        ("mn", "N", "did you mean 'mN' or 'MN'?"),
        ("kn", "N", "did you mean 'kN'?"),
        ("US", "s", "did you mean 'us'?"),
        ("mpa", "Pa", "did you mean 'MPa'?"),
        # Of another dimension, or a letter that may be any other.
        ("mn", "N/m^1.5", None),
        ("mn", "m", None),
        ("hz", "s", None),
    ],
)
def test_hints_are_units_of_the_dimension_asked_for(unit, si, hint):
    with pytest.raises(hc.InputError) as caught:
        converted("value", 3.0, unit, si)
    message = str(caught.value)
    assert f" ({hint}): choose from " in message if hint else "did you mean" not in message


def test_meganewtons_are_accepted():
    assert converted("force", "3", "MN", "N") == 3e6


STEEL = {"materials": "steel-304", "beads": 3}
ROW = hc.Chain.from_materials("5 mm", **STEEL)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: hc.Chain.from_materials("10,0 mm", **STEEL), "got '10,0 mm'; write 10.0 mm with"),
        (
            lambda: hc.Chain.from_materials(diameters="10,5 mm", **STEEL),
            "diameter must be a list of numbers, got '10,5 mm'; write 10.5 mm with a decimal point",
        ),
        (
            lambda: hc.Chain.from_materials(["10,5 mm", "5 mm"], "brass"),
            "radius of bead 1 is '10,5 mm': it must be a number; write 10.5 mm with a decimal",
        ),
        (lambda: hc.Chain.periodic("1,5 mm", cells=3, materials="brass"), "write 1.5 mm with a"),
        (lambda: ROW.replace(gaps="1,5 um"), "write 1.5 um with a decimal point"),
        (lambda: ROW.replace(masses=["1,5 g"] * 3), "write 1.5 g with a decimal point"),
        (lambda: hc.Wall("1,5 kN/mm", exponent=1), "stiffness of a wall .* write 1.5 kN/mm with a"),
        (lambda: ROW.with_cap("1,5 g"), "write 1.5 g with a decimal point"),
    ],
)
def test_decimal_commas_are_explained(call, said):
    with pytest.raises(hc.InputError, match=said):
        call()


@pytest.mark.parametrize(
    ("option", "text", "said"),
    [
        ("--diameter", "10,0 mm", "write 10.0 mm with a decimal point"),
        ("--radius", "10,5 mm:5 mm", "write 10.5 mm with a decimal point"),
        ("--striker", "1,5 g", "write 1.5 g with a decimal point, or a space after a comma that"),
        ("--cap", "5 g, 1,5 kN/mm", "write 1.5 kN/mm with a decimal point"),
        ("--wall", "1,5 kN/mm", "write 1.5 kN/mm with a decimal point"),
        ("--loss", "viscoelastic=0,6 us", "write 0.6 us with a decimal point"),
        ("--speed", "0,1 m/s", "write 0.1 m/s with a decimal point"),
    ],
)
def test_decimal_commas_of_options_are_explained(run, option, text, said):
    row = ["simulate", "--material", "brass", "--beads", "5", "--diameter", "10 mm"]
    row = row[:-2] if option in ("--diameter", "--radius") else row
    code, _, err = run(*row, option, text)
    assert code == 2
    assert said in " ".join(err.split())
