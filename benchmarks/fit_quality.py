"""Quality of fits: simulations, coverage of errors, starts, laws, defects and sensor effects.

    python benchmarks/fit_quality.py [--draws N] [--only NAME ...] [--json FILE]

All data are synthetic: 20 steel balls in front of a wall, struck at 0.3 m/s, sensors in balls 6,
11 and 16 and in the wall, 1 MHz, 500 us, 14 bits over 200 N, noise of 0.1 N.  Each draw has its
own stiffness, velocity, loss, gains, time offset and noise.  The rounded samples have 8 bits.
"""

import argparse
import json
import sys
import time
import warnings
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from synthetic_traces import STEP, bench, measured, recorded, signals

import hertzchain as hc
from hertzchain.fitting.sensors import Sensor, filtered, with_crosstalk

NINE = ["stiffness", "exponent", "struck_by.velocity", "time_offset", "gain[*]"]
LAWS = {
    "viscoelastic": (lambda rng: hc.Viscoelastic(rng.uniform(0.3e-6, 0.9e-6)), "loss.time"),
    "restitution": (lambda rng: hc.Restitution(rng.uniform(0.95, 0.99)), "loss.coefficient"),
    "unloading-ratio": (lambda rng: hc.UnloadingRatio(rng.uniform(0.03, 0.09)), "loss.ratio"),
    "dashpot": (lambda rng: hc.Dashpot(rng.uniform(2.0, 6.0)), "loss.gamma"),
    "walton-braun": (lambda rng: hc.WaltonBraun(rng.uniform(0.91, 0.97)), "loss.ratio"),
    "velocity-power": (
        lambda rng: hc.VelocityPower(4.0 * 0.1 ** (1.0 - 1.8), rng.uniform(1.5, 2.0)),
        "loss.gamma",
    ),
}
START = {
    "viscoelastic": hc.Viscoelastic(0.3e-6), "restitution": hc.Restitution(0.98),
    "unloading-ratio": hc.UnloadingRatio(0.03), "dashpot": hc.Dashpot(3.0),
    "walton-braun": hc.WaltonBraun(0.97), "velocity-power": hc.VelocityPower(10.0, 1.5),
}  # fmt: skip


def draw(law, seed, noise=0.1, step=STEP, phase=0.0, **options):
    """Traces, the truth by name, and priors of one draw."""
    rng = np.random.default_rng(seed)
    factor, velocity = 1.0 + 0.05 * rng.normal(), 0.3 * (1.0 + 0.02 * rng.normal())
    gains = 1.0 + 0.03 * rng.normal(size=4)
    offset, own = rng.uniform(0.0, 30e-6), LAWS[law][0](rng)
    chain = bench(own, velocity=velocity, factor=factor, **options)
    traces = measured(chain, rng, offset=offset, gains=gains, noise=noise, step=step, phase=phase)
    truth = {"stiffness": factor, "exponent": 1.5, "struck_by.velocity": velocity,
             "time_offset": offset}  # fmt: skip
    truth |= {f"gain[{name}]": gain for name, gain in zip(traces.names, gains, strict=True)}
    for name in own.parameters():
        if name != "attractive":
            truth[f"loss.{name}"] = getattr(own, name)
    gate = velocity * (1.0 + 0.01 * rng.normal())
    return traces, truth, {"struck_by.velocity": (gate, 0.01 * gate), "gain[*]": (1.0, 0.03)}


def free_of(law):
    """Free parameters with those of a law."""
    return NINE + [f"loss.{name}" for name in START[law].parameters() if name != "attractive"]


def cost(_):
    """Simulations and seconds for nine parameters, of equal balls and of a general chain."""
    traces, _, priors = draw("viscoelastic", 1)
    chains = {"equal balls": bench(START["viscoelastic"])}
    mixed = [hc.Restitution(0.97)] * 10 + [START["viscoelastic"]] * 10
    chains["general chain"] = bench(mixed, gravity=9.81)
    chains["general chain"] = chains["general chain"].replace(
        right_wall=hc.Wall(loss=START["viscoelastic"])
    )
    found = {}
    for name, chain in chains.items():
        data = traces
        if name != "equal balls":
            laws = [hc.Restitution(0.97)] * 10 + [hc.Viscoelastic(0.6e-6)] * 10
            truth = bench(laws, velocity=0.302, factor=1.02, gravity=9.81).replace(
                right_wall=hc.Wall(loss=hc.Viscoelastic(0.6e-6))
            )
            data = measured(truth, np.random.default_rng(1))
        free = [*NINE, "loss.time"]
        times = []
        for _ in range(3):
            begin = time.perf_counter()
            result = hc.fit(data, chain, free=free, priors=priors)
            times.append(time.perf_counter() - begin)
        found[name] = {"simulations": result.simulations, "seconds": min(times),
                       "describes": result.describes}  # fmt: skip
    return found


def coverage(draws):
    """Fractions of the errors within 1 and 2 sigma, for each law."""
    found = {}
    for index, law in enumerate(LAWS):
        scores, misses = [], 0
        for seed in range(draws):
            traces, truth, priors = draw(law, 10_000 * (1 + index) + seed)
            result = hc.fit(traces, bench(START[law]), free=free_of(law), priors=priors)
            misses += not result.converged or not result.describes
            scores.append([(result.values[n] - truth[n]) / result.errors[n] for n in result.names])
        z = np.abs(np.array(scores))
        own = np.array(scores)[:, [n in ("exponent", LAWS[law][1]) for n in result.names]]
        found[law] = {
            "within 1 sigma": float(np.mean(z < 1.0)), "within 2 sigma": float(np.mean(z < 2.0)),
            "largest": float(z.max()), "exponent and loss, sd of z": float(own.std()),
            "exponent and loss, mean of z": float(own.mean()),
            "not converged or not describing": misses,
        }  # fmt: skip
        print(law, found[law], flush=True)
    return found


def rounded(draws):
    """Coverage of the errors, with priors, of 8 bits over 100 N and noise of a part of a step."""
    step, found = 100 / 2**8, {}
    for part in (0.0, 0.05, 0.15, 0.25, 0.35, 0.55, 1.0):
        scores, ratios, above, misses = [], [], 0, 0
        for seed in range(draws):
            phase = np.random.default_rng(90_000 + seed).uniform(-0.5, 0.5, 4)
            digitiser = {"step": step, "phase": phase}
            traces, truth, priors = draw("viscoelastic", 80_000 + seed, part * step, **digitiser)
            free = [*[name for name in NINE if name != "exponent"], "loss.time"]
            result = hc.fit(traces, bench(START["viscoelastic"]), free=free, priors=priors)
            misses += not result.converged or not result.describes
            ratios.append(result.goodness.ratio)
            errors, gate = result.errors, priors["struck_by.velocity"][1]
            above += errors["struck_by.velocity"] > gate or any(
                errors[f"gain[{name}]"] > 0.03 for name in traces.names
            )
            scores.append([(result.values[n] - truth[n]) / errors[n] for n in result.names])
        z = np.abs(np.array(scores))
        found[part] = {
            "within 1 sigma": float(np.mean(z < 1.0)), "within 2 sigma": float(np.mean(z < 2.0)),
            "rms of z": float(np.sqrt(np.mean(z**2))), "mean chi2 ratio": float(np.mean(ratios)),
            "sd of chi2 ratio": float(np.std(ratios)), "errors above their prior": int(above),
            "not converged or not describing": misses,
        }  # fmt: skip
        print(part, found[part], flush=True)
    return found


def starts(draws):
    """Random starts that reach the optimum of one data set."""
    traces, _, priors = draw("viscoelastic", 7)
    rng = np.random.default_rng(8)
    costs = []
    for _ in range(draws):
        chain = bench(hc.Viscoelastic(np.exp(rng.uniform(np.log(0.05), np.log(2.0))) * 1e-6),
                      factor=np.exp(rng.uniform(-0.25, 0.25)))  # fmt: skip
        free = [*NINE, "loss.time"]
        result = hc.fit(traces, chain, free=free, priors=priors,
                        start={"exponent": rng.uniform(1.35, 1.65)})  # fmt: skip
        costs.append(result.chi2 + result.penalty)
    return {"reached": int(np.sum(np.array(costs) < min(costs) + 0.1)), "of": draws}


def laws(draws):
    """Number of draws in which the true law has the lowest BIC."""
    found = {}
    for law in LAWS:
        first, gaps = 0, []
        for seed in range(draws):
            traces, _, priors = draw(law, 2000 + seed)
            free = [name for name in NINE if name != "exponent"]
            compared = hc.compare_losses(traces, bench(), free=free, priors=priors)
            first += compared.fits[0].law == law
            best, second = compared.fits[:2]
            gaps.append(f"{best.law} {second.bic - best.bic:.1f} {second.law}")
        found[law] = {"first": first, "of": draws, "best, distance in BIC, next": gaps}
        print(law, found[law], flush=True)
    return found


def gaps(draws):
    """Number of draws in which a gap of 0.1 to 0.8 um is found at the right contact."""
    scan_right = fit_right = 0
    scores = []
    for seed in range(draws):
        rng = np.random.default_rng(3000 + seed)
        behind, gap = int(rng.integers(1, 19)), float(0.1e-6 * 8.0 ** rng.uniform())
        traces, _, priors = draw("viscoelastic", 3000 + seed, gap=gap, behind=behind)
        free = [*[name for name in NINE if name != "exponent"], "loss.time"]
        ignored = hc.fit(traces, bench(START["viscoelastic"]), free=free, priors=priors)
        scan = hc.scan_defects(ignored)
        name = f"gap[{behind}-{behind + 1}]"
        scan_right += scan.best == name
        found = scan.fit()
        fit_right += name in found.names
        if name in found.names:
            scores.append((found.values[name] - gap) / found.errors[name])
    return {"right in the scan": scan_right, "right after the fit": fit_right, "of": draws,
            "sd of z of the gap": float(np.std(scores))}  # fmt: skip


def balls(draws):
    """Number of draws in which a ball whose radius differs by 10% is found, and distances to it."""
    away = []
    for seed in range(draws):
        rng = np.random.default_rng(7000 + seed)
        odd, start = int(rng.integers(2, 20)), bench(START["viscoelastic"])
        radii = start.radii.copy()
        radii[odd] *= rng.choice((0.9, 1.1))  # behind one striker
        chain = start.replace(radii=radii)
        free = ["stiffness", "struck_by.velocity", "time_offset", "loss.time"]
        scan = hc.scan_defects(hc.fit(measured(chain, rng), start, free=free), "bead")
        names = scan.best, scan.fit().names[-1]
        away.append([abs(int(name.removeprefix("radius[")[:-1]) - odd) for name in names])
    scanned, fitted = np.array(away).T
    return {"right in the scan": int(np.sum(scanned == 0)), "largest distance": int(scanned.max()),
            "right after the fit": int(np.sum(fitted == 0)),
            "largest distance after the fit": int(fitted.max()), "of": draws}  # fmt: skip


def sensors(draws):
    """Mean and largest bias of chain parameters with lag, high-pass and crosstalk free."""
    lag, rate, share = 2e-6, 200.0, 0.01
    rows = []
    for seed in range(draws):
        rng = np.random.default_rng(4000 + seed)
        offset = rng.uniform(0.0, 30e-6)
        chain = bench(hc.Viscoelastic(0.6e-6))
        # On a grid eight times as fine as the samples, where the filters are accurate to 1e-5.
        times, seen = signals(chain, 500e-6, offset, spacing=0.125e-6)
        sensor = Sensor(lag=lag, highpass=rate)
        columns = [filtered(column, 0.125e-6, sensor) for column in seen.T]
        mixed = np.column_stack(with_crosstalk(columns, ["N"] * 4, share))
        traces = recorded(times[::8], mixed[::8], rng)
        free = [*NINE, "loss.time", "lag", "highpass", "crosstalk"]
        priors = {"struck_by.velocity": (0.3 * (1 + 0.01 * rng.normal()), 0.003),
                  "gain[*]": (1.0, 0.03)}  # fmt: skip
        result = hc.fit(traces, bench(START["viscoelastic"]), free=free, priors=priors)
        truth = {"stiffness": 1.0, "exponent": 1.5, "loss.time": 0.6e-6, "lag": lag,
                 "highpass": rate, "crosstalk": share, "time_offset": offset}  # fmt: skip
        rows.append([(result.values[n] - true) / result.errors[n] for n, true in truth.items()])
    z = np.array(rows)
    return {"largest mean bias in sigma": float(np.abs(z.mean(axis=0)).max()),
            "of": draws, "error of a mean": draws**-0.5,
            "sd of z": dict(zip(truth, z.std(axis=0).round(2), strict=True)),
            "mean of z": dict(zip(truth, z.mean(axis=0).round(2), strict=True))}  # fmt: skip


def degeneracies(_):
    """Degenerate problems: whether the direction is named."""
    data, *_ = draw("viscoelastic", 5)
    one = hc.Traces((hc.Traces.from_arrays(
        data.shots[0].times, {"ball 11 [mV]": 48.0 * data.shots[0].signals[1].values},
    ).shots[0],))  # fmt: skip
    wanted = {
        "nothing calibrated": (data, ["stiffness", "struck_by.velocity", "loss.time",
                                      "time_offset", "gain[*]"], 1),
        "offset and delay of all sensors": (data, ["stiffness", "time_offset", "delay"], 1),
        "one sensor without calibration": (one, ["stiffness", "struck_by.velocity", "time_offset",
                                                 "gain[ball 11]", "loss.time"], 1),
        "modulus and stiffness": (data, ["stiffness", "materials[steel].young",
                                         "time_offset", "loss.time"], 1),
        "well posed": (data, ["stiffness", "struck_by.velocity", "time_offset", "loss.time"], 0),
    }  # fmt: skip
    found = {}
    for name, (traces, free, count) in wanted.items():
        result = hc.fit(traces, bench(START["viscoelastic"]), free=free)
        silent = [n for n, v in result.values.items()
                  if result.errors[n] > abs(v) and not any(n in w.weights for w in result.weak)
                  and n not in " ".join(result.warnings)]  # fmt: skip
        found[name] = {"named": len(result.weak) == count, "errors above 100% without a word":
                       silent, "direction": [str(each) for each in result.weak]}  # fmt: skip
    return found


SECTIONS = (cost, degeneracies, starts, gaps, balls, sensors, coverage, rounded, laws)


def main():
    """Measure and print all sections."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--only", nargs="*", choices=[each.__name__ for each in SECTIONS])
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    warnings.simplefilter("ignore", hc.ModelRangeWarning)
    document = {}
    for section in SECTIONS:
        name = section.__name__
        if given.only and name not in given.only:
            continue
        begin = time.perf_counter()
        document[name] = section(given.draws)
        print(f"{name} ({time.perf_counter() - begin:.0f} s):", flush=True)
        print(json.dumps(document[name], indent=2), flush=True)
    if given.json is not None:
        given.json.write_text(json.dumps(document, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
