"""Summaries of runs with drives."""

import json

import hertzchain as hc


def test_an_endless_shaker_gives_no_last_bead_in_the_leading_pulse(run, tmp_path):
    row = hc.Chain.uniform(6).replace(
        precompression=0.1, held_by="force", velocities=[0.0] * 6, loss=hc.Dashpot(0.05)
    )
    shaker = {"amplitude": 0.01, "frequency": 0.2, "window": "none"}
    found = {}
    for name, cycles in (("endless", float("inf")), ("burst", 2.0)):
        driven = row.replace(drive=hc.SineBurst(cycles=cycles, **shaker))
        (tmp_path / f"{name}.toml").write_text(hc.chain_as_toml(driven))
        _, out, _ = run("simulate", tmp_path / f"{name}.toml", "--until", "60", "--json")
        found[name] = json.loads(out)["last_bead"]
    assert found["endless"] is None
    assert found["burst"] is not None
