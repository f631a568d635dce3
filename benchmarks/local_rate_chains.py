"""Random chains of all kinds, with their own generator, which differs from that of training."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

SMOOTH = ("sines", "spline", "sigmoids", "power", "gauss", "chirp", "ramps", "noise")
SCATTERS = (0.001, 0.003, 0.01, 0.02)
LINEAR_SCATTERS = (0.003, 0.01, 0.02, 0.05)
ALTERNATING = (0.99, 0.97, 0.9)
HIGHEST, LONGEST = 0.3, 25.0
# Changes of a taper that are so small that a warning is just missing.
CHANGES = (
    "none", "one odd bead", "one step", "kink", "scatter", "alternating", "decorated",
    "step at the end", "cluster of odd beads",
)  # fmt: skip
Named = list[tuple[str, np.ndarray]]


def shape(random: np.random.Generator, kind: str, contacts: int) -> np.ndarray:
    """Rates of a smooth taper, with any amplitude."""
    k = np.arange(contacts)
    if kind == "sines":
        periods = np.exp(random.uniform(np.log(15.0), np.log(200.0), 3))
        phases = random.uniform(0.0, 7.0, 3)
        return np.sin(2.0 * np.pi * k[:, None] / periods + phases) @ random.normal(size=3)
    if kind == "spline":
        points = max(4, int(contacts / random.uniform(12.0, 40.0)) + 2)
        return CubicSpline(np.linspace(0, contacts, points), random.normal(size=points))(k)
    if kind == "sigmoids":
        centres, widths = random.uniform(0, contacts, 3), random.uniform(4.0, 25.0, 3)
        return np.cosh((k[:, None] - centres) / widths) ** -2.0 @ random.normal(size=3)
    if kind == "power":
        return random.choice((-1, 1)) / (k + random.uniform(5.0, 60.0))
    if kind == "gauss":
        white = random.normal(size=contacts + 200)
        return gaussian_filter1d(white, random.uniform(5.0, 30.0))[100 : 100 + contacts]
    if kind == "chirp":
        period, faster = np.exp(random.uniform(np.log(20), np.log(80))), random.uniform(0, 0.7)
        cycles = k / period * (1.0 + faster * k / contacts)
        return np.sin(2.0 * np.pi * (cycles + random.random()))
    if kind == "ramps":
        corners = np.sort(random.uniform(0, contacts, 4))
        return np.interp(k, [0, *corners, contacts], random.normal(size=6))
    values, x = random.normal(size=400), k / random.uniform(10.0, 60.0)
    cell, t = x.astype(int), x % 1.0
    t = t**3 * (t * (6.0 * t - 15.0) + 10.0)
    return values[cell] * (1.0 - t) + values[cell + 1] * t


def smooth_rates(
    random: np.random.Generator, kind: str, contacts: int, top: float, lowest: float
) -> np.ndarray:
    """Rates of a smooth taper; some change around another rate than 0."""
    while True:
        rates = shape(random, kind, contacts)
        rates = rates / np.abs(rates).max() * top
        rates += random.normal() * 0.02 if random.random() < 0.4 else 0.0
        if rates.min() > lowest and rates.max() < HIGHEST and abs(rates.sum()) < LONGEST:
            return rates


def class_of(rates: np.ndarray) -> str:
    """Class of a taper: by its roughness and its lowest rate."""
    if np.abs(np.diff(rates)).max() > 0.005:
        return "tapers, rough"
    for limit in (0.0, -0.02, -0.05, -0.1):
        if rates.min() > limit:
            return f"tapers, smooth, lowest rate > {limit:g}"
    return "tapers, smooth, any rate"


def scattered(random: np.random.Generator, scatter: float, beads: int = 100) -> np.ndarray:
    """Rates of beads with random radii."""
    return np.diff(np.log(1.0 + scatter * random.standard_normal(beads)))


def chains_by_kind(count: int, seed: int, lowest: float = -0.14) -> Named:
    """Rates of chains with the name of their class; ``count`` chains in most classes."""
    random = np.random.default_rng(seed)
    found: Named = []

    def taper(kind: str, low: float, high: float, contacts: int | None = None) -> np.ndarray:
        contacts = contacts or int(np.exp(random.uniform(np.log(20), np.log(300)))) - 1
        top = np.exp(random.uniform(np.log(low), np.log(high)))
        return smooth_rates(random, kind, contacts, top, lowest)

    for i in range(8 * count):
        rates = taper(SMOOTH[i % 8], 0.004, 0.12)
        found.append((class_of(rates), rates))
    for scatter in SCATTERS:
        for i in range(count):
            found.append((f"equal beads, scatter {scatter:.1%}", scattered(random, scatter)))
            rates = taper(SMOOTH[i % 8], 0.01, 0.06, 99) + scattered(random, scatter)
            found.append((f"tapers, scatter {scatter:.1%}", rates))
    for ratio in ALTERNATING:
        for first, second in ((1.0, ratio), (ratio, 1.0)):
            radii = np.resize([first, second], 100)
            found.append((f"alternating 1 : {ratio:g}", np.diff(np.log(radii))))
    for i in range(count):
        rates = taper(SMOOTH[i % 8], 0.004, 0.06, int(random.integers(8, 19)))
        found.append(("short tapers, 9 to 19 beads", rates))
        step = np.zeros(int(random.integers(20, 150)))
        step[random.integers(1, len(step))] = random.normal() * 0.15
        found.append(("one step of radius", step))
        cells = random.uniform(0.3, 1.0, int(random.integers(2, 4)))
        found.append(("periodic chains", np.diff(np.log(np.resize(cells, 60)))))
        odd = np.ones(64)
        odd[random.integers(1, 64)] = np.exp(random.normal() * 0.3)
        found.append(("one odd bead", np.diff(np.log(odd))))
        decorated = np.ones(int(random.integers(20, 150)))
        decorated[1 :: random.integers(2, 5)] = np.exp(-np.exp(random.uniform(-6.0, 0.4)))
        found.append(("decorated chains", np.diff(np.log(decorated))))
    return found


def bases(random: np.random.Generator, contacts: int, lowest: float) -> np.ndarray:
    """Rates of a taper, often a steep one, also towards its free end."""
    kind = random.integers(4)
    steepest = 1.05 * lowest
    if kind == 0:
        return np.full(contacts, random.uniform(steepest, 0.3))
    if kind == 1:
        return np.linspace(*random.uniform(steepest, 0.2, 2), contacts)
    if kind == 2:
        width = random.uniform(2, 20)
        inside, end = random.uniform(-0.05, 0.02), random.uniform(1.1 * lowest, 0.4 * lowest)
        return inside + (end - inside) * np.exp(-(contacts - 1 - np.arange(contacts)) / width)
    while True:
        rates = shape(random, SMOOTH[random.integers(8)], contacts)
        top = np.exp(random.uniform(np.log(0.01), np.log(0.15)))
        rates = rates / np.abs(rates).max() * top + random.normal() * 0.03
        if rates.min() > 1.14 * lowest and rates.max() < 0.4:
            return rates


def changed(random: np.random.Generator, rates: np.ndarray, change: str) -> np.ndarray:
    """Rates with a change whose size is that of a faint up to a strong one."""
    contacts = len(rates)
    size = np.exp(random.uniform(np.log(3e-4), np.log(0.08))) * random.choice((-1, 1))
    j = int(random.integers(0, contacts - 1))
    found = rates.copy()
    if change == "one odd bead":
        found[j : j + 2] += size, -size
    elif change == "one step":
        found[j] += size
    elif change == "kink":
        found[j:] += size / 2
    elif change == "scatter":
        found += np.diff(abs(size) / 4 * random.normal(size=contacts + 1))
    elif change == "alternating":
        found += np.diff(np.resize([0, size / 4], contacts + 1))
    elif change == "decorated":
        cell = [0] * int(random.integers(1, 4)) + [size / 3]
        found += np.diff(np.resize(cell, contacts + 1))
    elif change == "step at the end":
        found[contacts - 1 - int(random.integers(0, 6))] += size
    elif change == "cluster of odd beads":
        beads = int(random.integers(2, 5))
        j = int(random.integers(0, contacts - beads))
        found[j : j + beads] += np.diff(size * random.normal(size=beads + 1))
    return found


def steep_chains(count: int, seed: int, lowest: float = -0.14) -> Named:
    """Steep tapers with small changes of each kind, ``count`` of each: hard for the estimate."""
    random = np.random.default_rng(seed)
    found: Named = []
    for _ in range(count):
        contacts = int(np.exp(random.uniform(np.log(8), np.log(150))))
        for change in CHANGES:
            rates = bases(random, contacts, lowest)
            rates *= min(1.0, LONGEST / max(abs(rates.sum()), 1e-9))
            rates = changed(random, rates, change)
            if rates.min() > 1.17 * lowest and rates.max() < 1.1:
                found.append((f"steep tapers, {change}", rates))
    return found


def forward_chains(count: int, seed: int, lowest: float = -0.14) -> Named:
    """Forward tapers whose radii scatter, and tapers that begin with quick changes."""
    random = np.random.default_rng((seed, 1))
    found: Named = []
    for i in range(count):
        for scatter in SCATTERS[1:3]:
            mean = random.uniform(0.7 * lowest, 0.25 * lowest)
            rates = np.full(59, mean)
            if i % 2:
                wave = shape(random, SMOOTH[i % 8], 59)
                rates += random.uniform(0.2, 0.6) * abs(mean) * wave / np.abs(wave).max()
            rates += scattered(random, scatter, 60)
            found.append((f"forward tapers, scatter {scatter:.1%}", rates))
        beads = np.arange(1.0, random.integers(30, 120))
        radii = (beads + random.uniform(0.0, 10.0)) ** random.uniform(-0.5, 1.5)
        found.append(("power laws from the start", np.diff(np.log(radii))))
    return found


def backward_linear_chains(count: int, seed: int) -> Named:
    """Backward-linear tapers whose radii scatter: first, steep rates change quickly."""
    random = np.random.default_rng((seed, 2))
    found: Named = []
    for _ in range(count):
        for scatter in LINEAR_SCATTERS:
            step = np.exp(random.uniform(np.log(0.05), np.log(1.5)))
            rates = np.diff(np.log1p(step * np.arange(60.0))) + scattered(random, scatter, 60)
            found.append((f"backward-linear, scatter {scatter:.1%}", rates))
    return found


def all_chains(count: int, seed: int, lowest: float = -0.14) -> Named:
    """Chains of all classes."""
    makers = (chains_by_kind, steep_chains, forward_chains)
    found = [each for make in makers for each in make(count, seed, lowest)]
    return found + backward_linear_chains(count, seed)
