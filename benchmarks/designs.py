"""Measure designs and gradients: values reached, and the processor time used.

    python benchmarks/designs.py [name ...]

Without names, all rows are measured.  Times are those of this process in all its threads; the first
column states a limit that each value or time must keep.  A table of the documentation contains the
results (`docs/explanation/designs.md`).
"""

import argparse
import sys
import time
import warnings
from pathlib import Path

import numpy as np

import hertzchain as hc
from hertzchain.derivatives import gradient as module

LONG = hc.Chain.uniform(100)
BUDGETS = {20: "30 s", 60: "60 s"}


def spent(function, *args, **options):
    """Result of a function, processor time, and elapsed time."""
    cpu, wall = time.process_time(), time.perf_counter()
    result = function(*args, **options)
    return result, time.process_time() - cpu, time.perf_counter() - wall


def show(name, limit, value, cpu=float("nan"), wall=float("nan"), note=""):
    """Print one row."""
    print(f"{name:<48}{limit:<16}{value:<22}{cpu:>8.2f}{wall:>8.2f}  {note}", flush=True)


def shortest(function, repetitions=30):
    """Shortest processor time."""
    times = []
    for _ in range(repetitions):
        began = time.process_time()
        function()
        times.append(time.process_time() - began)
    return min(times)


def gradients():
    """A column of the pulse of 100 beads, and gradients compared with the run itself."""
    for name, chain in (
        ("forward", hc.Chain.tapered("forward-exponential", 0.01, beads=100)),
        ("uniform", LONG),
        ("backward", hc.Chain.tapered("backward-exponential", 0.03, beads=100)),
    ):
        own = shortest(lambda chain=chain: hc.gradient(chain, "pulse.velocity@90"))
        plain = shortest(lambda chain=chain: hc.propagate(chain))
        show(f"gradient of velocity@90, {name}", "3 ms", f"{1e3 * own:.2f} ms", own, own,
             f"propagate {1e3 * plain:.2f} ms")  # fmt: skip
    for beads in (20, 100, 300):
        chain = hc.Chain.tapered("forward-exponential", 0.3 / beads, beads=beads)
        chain = chain.replace(right_wall=hc.Wall())
        own = shortest(lambda chain=chain: hc.gradient(chain, "wall_force.peak"), 7)
        plain = shortest(
            lambda chain=chain: hc.simulate_many(
                [chain], keep="wall_peak_force", rtol=1e-10, threads=1
            ),
            7,
        )
        show(f"gradient of the wall's peak, {beads} beads", "3.5 runs", f"{own / plain:.2f} runs")


def errors():
    """Gradients against long-double differences on the same steps, and against a finer run."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
    from long_double_steps import derivative

    chain = hc.Chain.tapered("forward-exponential", 0.03, beads=20).replace(right_wall=hc.Wall())
    kept = {}
    run, backward_pass = module.run, module.backward_pass
    module.run = lambda *args: kept.setdefault("record", run(*args))
    module.backward_pass = lambda *args: kept.setdefault("slopes", backward_pass(*args))
    hc.gradient(chain, "wall_force.impulse", to="masses", until=40.0)
    module.run, module.backward_pass = run, backward_pass
    record, worst = kept["record"], 0.0
    lengths = np.concatenate([block.lengths for block in record.blocks])
    for name in ("masses", "stiffness"):
        exact = getattr(kept["slopes"], name)
        for index in (1, 9, 18):
            found = derivative(
                record.equation, name, index, lengths, lambda at: at.impulse[-1], 1e-8
            )
            worst = max(worst, abs(exact[index] - found) / np.abs(exact).max())
    show("gradient against long double, same steps", "1e-7", f"{worst:.1e}")
    for name, end in (("forward", chain), ("backward, free", None)):
        if end is None:
            end = hc.Chain.tapered("backward-exponential", 0.03, beads=100)
            until = 1.2 * hc.propagate(end).peak_time[90]
            fine = hc.gradient(end, "pulse.velocity@90", until=until, rtol=1e-12)
            found = hc.gradient(end, "pulse.velocity@90")
        else:
            fine = hc.gradient(end, "wall_force.peak", rtol=1e-14)
            found = hc.gradient(end, "wall_force.peak")
        error = np.abs(found["radii"] - fine["radii"]).max() / np.abs(fine["radii"]).max()
        show(f"gradient against the exact flow, {name}", "1e-3", f"{error:.1e}",
             note=f"stated {found.error:.1e}")  # fmt: skip


def law():
    """Smooth designs of 100 beads, for which the search uses the law; then polished."""
    for kind, measure, limit in (
        ("minimise", "velocity@90", "0.060 in 2 s"),
        ("maximise", "velocity@90", "4.05"),
        ("maximise", "momentum@90", "3.6"),
    ):
        vary = [hc.vary.radii(0.3, 3.0, by="spline", knots=24)]
        problem = hc.Design(LONG, vary=vary, **{kind: measure})
        # The evaluation of the references, of which there are 82, and of the law's design.
        for name, budget in (("law", 84), ("polished", 1000)):
            found, *times = spent(hc.design, problem, budget=budget)
            promised = found.expected if found.promise is None else found.promise[0]
            taper = found.references["taper"]
            later = "; a later maximum is larger" if any("later" in n for n in found.notes) else ""
            show(f"{kind} {measure}, {name}", limit, f"{found.value:.4f}", *times,
                 f"{found.value / promised - 1.0:+.1e} of the promise{later}; best taper "
                 f"{found.objective_of(taper):.4g}")  # fmt: skip


def walls():
    """Peak force on a wall behind beads of radius 0.5 to 1."""
    for beads, limit in ((20, "0.265 in 30 s"), (60, "0.155 in 60 s")):
        chain = hc.Chain.uniform(beads).replace(right_wall=hc.Wall())
        problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)])
        for method in ("gradient", "evolution", "hybrid"):
            found, *times = spent(hc.design, problem, budget=BUDGETS[beads], method=method)
            show(f"wall, {beads} beads, {method}", limit, f"{found.value:.4f}", *times,
                 f"{len(found.finals)} starts")  # fmt: skip


def ranges():
    """Descents alone and with an evolution strategy, for radii within close and wide limits."""
    for beads, limits in ((13, (0.5, 0.2)), (20, (0.2,)), (27, (0.2,)), (40, (0.5, 0.2))):
        for low in limits:
            chain = hc.Chain.uniform(beads).replace(right_wall=hc.Wall())
            problem = hc.Design(chain, minimise="wall_force.peak", vary=[hc.vary.radii(low, 1.0)])
            for method in ("gradient", "hybrid"):
                found, *times = zip(*(
                    spent(hc.design, problem, budget="15 s", method=method, seed=seed, threads=1)
                    for seed in range(3)
                ), strict=True)  # fmt: skip
                values = ", ".join(f"{each.value:.3f}" for each in found)
                show(f"wall, {beads} beads, radii {low} to 1, {method}", "", values,
                     *map(sum, times), "three seeds")  # fmt: skip


def scatter():
    """CVaR of the peak force with deviations of 1% of the radii."""
    chain = hc.Chain.uniform(20).replace(right_wall=hc.Wall())
    problem = hc.Design(
        chain, minimise="wall_force.peak", vary=[hc.vary.radii(0.5, 1.0)],
        scatter={"radius": 0.01, "measure": "cvar90"},
    )  # fmt: skip
    found, *times = spent(hc.design, problem, budget="20 s")
    new = found.verified.scattered["CVaR90 of wall_force.peak"]
    show("CVaR90, 20 beads", "0.290 in 20 s", f"{new:.4f}", *times, "400 new samples")


def balls():
    """Steel and PTFE in 15 places: all sequences, and genetic searches among them."""
    steel = "steel-304"
    chain = hc.Chain.from_materials(
        2.38e-3, steel, beads=16, velocity=1.0, right_wall=hc.Wall.of(steel)
    )
    vary = [hc.vary.balls(materials=[steel, "ptfe"], diameters=["4.76 mm"])]
    problem = hc.Design(chain, minimise="wall_force.peak", vary=vary)
    found, *times = spent(hc.design, problem, budget=40_000)
    show("all 32768 sequences", "10 s", f"{found.value:.4g} N", *times, found.method)
    reached = 0
    cpu, wall = 0.0, 0.0
    for seed in range(20):
        one, *times = spent(hc.design, problem, budget=4000, method="genetic", seed=seed)
        reached += one.value <= found.value * (1.0 + 1e-6)
        cpu, wall = cpu + times[0], wall + times[1]
    show("genetic search, 4000 runs", "20 of 20", f"{reached} of 20", cpu, wall)


def fronts():
    """Parts of complete Pareto fronts that genetic searches find, in the mean over five seeds."""

    def row(beads, **more):
        return hc.Chain.from_materials("3.175 mm", "steel-52100", beads=beads, velocity=0.2, **more)

    def sizes(*diameters, materials="steel-52100", **more):
        each = [f"{size} mm" for size in diameters]
        return [hc.vary.balls(materials=materials, diameters=each, beads="2:", **more)]

    wall = {"right_wall": hc.Wall.of("steel-52100")}
    drawer = hc.Chain.from_materials(
        0.5e-3 * np.array([6.35] + 4 * [8.0] + 4 * [5.0] + 4 * [4.0]), "steel-52100",
        velocity=0.2, **wall,
    )  # fmt: skip
    force = "wall_force.peak"
    for name, problem in {
        "force and mass, 5 sizes, 7 places": hc.Design(
            row(8, **wall), minimise=[force, "mass"], vary=sizes(3, 4, 5, 6.35, 8, optional=True)),
        "force and length, elastic": hc.Design(
            row(8, **wall), minimise=[force, "length"], subject_to={"yield_ratio": "<= 1"},
            vary=sizes(3, 4, 5, 6.35, 8, optional=True)),
        "force and mass, steel and PTFE": hc.Design(
            row(16, **wall), minimise=[force, "mass"],
            vary=sizes(4.7625, materials=["steel-52100", "ptfe"])),
        "force and arrival, order of 12": hc.Design(
            drawer, minimise=[force, "arrival@last"], vary=[hc.vary.order(beads="2:")]),
        "momentum and velocity, 4 sizes": hc.Design(
            row(9), maximise=["momentum@last", "velocity@last"], vary=sizes(3, 4, 5, 6.35)),
    }.items():  # fmt: skip
        best = _costs(hc.design(problem, budget=100_000, method="enumerate"))
        for budget in (1000, 4000):
            found, cpu, wall_time = [], 0.0, 0.0
            for seed in range(5):
                one, *times = spent(hc.design, problem, budget=budget, method="genetic", seed=seed)
                found.append(_costs(one))
                cpu, wall_time = cpu + times[0], wall_time + times[1]
            share = np.mean([_dominated(each, best) for each in found])
            points = np.mean([_points_found(each, best) for each in found])
            show(f"{name}, {budget} runs", "", f"{share:.2%} of the area", cpu / 5, wall_time / 5,
                 f"{points:.0%} of {len(best)} points")  # fmt: skip


def _costs(result):
    """Both objectives of all points of a front, to be minimised."""
    return np.array([
        [np.sign(each.weights[0]) * point.values[str(each.single)]
         for each in result.problem.objectives]
        for point in result.front
    ])  # fmt: skip


def _dominated(front, best):
    """Area that a front dominates, relative to that of the complete one.

    Both are bounded 10% beyond the ends of the complete front.
    """
    low, span = best.min(axis=0), np.ptp(best, axis=0)

    def area(points):
        total, lowest = 0.0, 1.1
        for one, other in sorted(map(tuple, (points - low) / span)):
            if one < 1.1 and other < lowest:
                total += (1.1 - one) * (lowest - other)
                lowest = other
        return total

    return area(front) / area(best)


def _points_found(front, best):
    """Part of the points of the complete front that no point of another front misses."""
    close = 1e-4 * np.abs(best)
    return np.mean([(front <= point + near).all(axis=1).any()
                    for point, near in zip(best, close, strict=True)])  # fmt: skip


def gaps():
    """The default method for gaps, and the evolution strategy with five times the simulations."""
    chain = hc.Chain.uniform(12).replace(right_wall=hc.Wall())
    for name, vary in (
        ("gaps", [hc.vary.gaps(0.0, 0.5)]),
        ("radii and gaps", [hc.vary.radii(0.5, 1.0), hc.vary.gaps(0.0, 0.3)]),
    ):
        problem = hc.Design(chain, minimise="wall_force.peak", vary=vary)
        for method, budget in (("auto", 3000), ("evolution", 15_000)):
            found, *times = zip(*(
                spent(hc.design, problem, method=method, budget=budget, seed=seed)
                for seed in range(3)
            ), strict=True)  # fmt: skip
            values = [each.value for each in found]
            show(f"force on a wall, {name}, {method}", "", f"{min(values):.4f}",
                 *map(sum, times), f"worst of three seeds {max(values):.4f}")  # fmt: skip


def closed_forms():
    """Optima that are known."""
    problem = hc.Design(
        hc.Chain.dimer(0.5, beads=100), maximise="velocity@91/velocity@31",
        vary=[hc.vary.masses(0.05, 0.6, beads="2::2", by="common")],
    )  # fmt: skip
    found, *times = spent(hc.design, problem)
    ratios = np.array([each.chain.masses[1] for each in found.optima])
    worst = max(np.abs(ratios / known - 1.0).min() for known in (0.3428, 0.1548, 0.0901, 0.0615))
    show("dimers: four published mass ratios", "1e-3", f"{worst:.1e}", *times)
    masses = np.ones(7)
    masses[-1] = 0.1
    chain = hc.Chain(np.cbrt(masses), masses=masses, stiffness=np.ones(6))
    vary = [hc.vary.masses(0.05, 1.5, beads="2:6")]
    problem = hc.Design(chain, maximise="velocity@last", model="hard-sphere", vary=vary)
    found, *times = spent(hc.design, problem, method="gradient")
    error = np.abs(found.chain.masses / 0.1 ** (np.arange(7) / 6) - 1.0).max()
    show("hard spheres: geometric masses", "1e-6", f"{error:.1e}", *times)


ROWS = {
    each.__name__: each
    for each in (gradients, errors, law, walls, ranges, gaps, scatter, balls, fronts, closed_forms)
}


def main():
    """Compile, then print the chosen rows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="name", help=f"any of {', '.join(ROWS)}")
    names = parser.parse_args().names or list(ROWS)
    if unknown := sorted({*names} - {*ROWS}):
        parser.error(f"unknown name {unknown[0]!r}; the names are {', '.join(ROWS)}")
    warnings.simplefilter("ignore")
    hc.warm_up()
    print(f"{'row':<48}{'must':<16}{'value':<22}{'CPU, s':>8}{'s':>8}")
    for name in names:
        ROWS[name]()


if __name__ == "__main__":
    main()
