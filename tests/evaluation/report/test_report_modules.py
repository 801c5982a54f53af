"""Modules on the page: what a spiking controller's diagnostics say, in figures with a known answer."""

import re
from dataclasses import replace

import numpy as np
import pytest
from torquebench.scenarios.trace import encode_trace

MASSES = (1.5, 2.5, 3.5)
LAPS, LAP = 4, 3.0
GRIPPER = 1.186


def trace_of(*, gains=True):
    """Gains in opposition on the first joint, moving together on the second, still on the third."""
    t = np.arange(-100, round(LAPS * LAP / 1e-2)) * 1e-2
    q = np.full((len(t), 3), 0.01)
    wave = np.sin(2.0 * np.pi * t)
    still = np.full_like(wave, 200.0)
    arrays = {"t": t, "q": q, "q_ref": np.zeros_like(q)}
    if gains:
        arrays["diagnostics/stiffness"] = np.stack([200.0 + wave, 200.0 + wave, still], axis=1)
        arrays["diagnostics/damping"] = np.stack([20.0 - wave, 20.0 + wave, 20.0 + wave], axis=1)
    return encode_trace({name: array.astype(np.float32) for name, array in arrays.items()})


def put(shelf, controller, trajectory, mass, *, repetition=0, trace=True, shown=True):
    run = replace(shelf.specification(controller, "none", trajectory, mass), laps=LAPS, repetition=repetition)
    result = shelf.result(run, 1e-2, "slow")
    weight = (mass - GRIPPER) / 3.0
    weights = {"run_mean": [1.0 - weight, weight], "last_lap_mean": [1.0 - weight, weight]}
    figures = {
        "weights": weights,
        "spikes_granule": {"run_mean": [750.0, 750.0]},
        "spikes_brainstem": {"run_mean": [15.0] * 5 + [0.0] * 5},
    }
    operations = {"cerebellum_effective_macs": 26_000_000, "cerebellum_executed_macs": 13_000_000, "thalamus_dense": 7}
    shelf.put(
        run,
        replace(
            result,
            repetition=repetition,
            diagnostics=figures if shown else {},
            counts={**result.counts, "operations": operations if shown else {}},
            provenance={
                **result.provenance,
                "payload": [mass - GRIPPER] + [0.0] * 9,
                "tick_s": 1e-3,
                "diagnostics": {"stiffness": 10, "damping": 10, "weights": 10},
            },
            trace=trace_of() if trace else None,
        ),
    )


@pytest.fixture
def modules(shelf):
    for controller in ("cbmc_v3", "light_only", "heavy_only"):
        for trajectory in ("S1", "S2"):
            for mass in MASSES:
                for repetition in range(2):
                    put(shelf, controller, trajectory, mass, repetition=repetition)
    return shelf.campaign()


def test_a_store_without_modules_has_no_such_section(quick):
    assert "w1-modules" not in quick.html
    assert "modules" not in quick.summary["worlds"][0]


def test_the_weight_stands_beside_the_right_one(modules):
    page = modules.report()
    found = page.summary["worlds"][0]["modules"]
    for mass in MASSES:
        assert found["heavy_weight_by_load"][f"{mass:g}"] == pytest.approx([(mass - GRIPPER) / 3.0] * 2)
    assert found["weight_slope_per_kg"]["median"] == pytest.approx(1.0 / 3.0)
    assert "grows by 0.333 per kg" in page.html
    assert "right: load beyond the gripper / 3 kg" in page.html


def test_the_error_by_load_has_a_curve_for_each_pattern_and_both(modules):
    page = modules.report()
    figure = re.search(r'<figure id="w1-load-error".*?</figure>', page.html, re.DOTALL).group()
    for label in ("light_only / none", "heavy_only / none", "cbmc_v3 / none"):
        assert f"<title>{label}</title>" in figure
    assert figure.count('class="band') == 3


def test_gains_in_opposition_correlate_at_minus_one_in_the_table(modules):
    """A joint whose gain stands still has no correlation."""
    found = modules.report().summary["worlds"][0]["modules"]["gain_correlation"]["cbmc_v3 / none"]
    for cut in ("raw", "laps", "late"):
        assert [joint["median"] for joint in found[cut][:2]] == pytest.approx([-1.0, 1.0], abs=1e-4)
        assert found[cut][2]["median"] is None
        assert found[cut][2]["without_value"] == {"undefined": 12}


def test_spikes_by_neuron_and_step(modules):
    found = modules.report().summary["worlds"][0]["modules"]["spike_rate"]["cbmc_v3 / none"]
    assert found["spikes_granule"]["median"] == pytest.approx(750.0 / (300 * 10))
    assert found["spikes_brainstem"]["median"] == pytest.approx(0.5)


def test_operations_by_second_as_defined_and_as_executed(modules):
    """Two ways of counting, never summed; a run of 13 s did 26 million."""
    page = modules.report()
    found = page.summary["worlds"][0]["modules"]["operations_per_s"]["cbmc_v3 / none"]
    assert found["cerebellum_effective_macs"]["median"] == pytest.approx(2e6)
    for header in ("Forward, as defined", "Forward, as executed", "Learning"):
        assert f'scope="colgroup">{header}</th>' in page.html
    assert "no energy" in page.html


def test_without_traces_the_tables_remain(shelf):
    for mass in MASSES:
        put(shelf, "cbmc_v3", "S1", mass, trace=False)
    page = shelf.campaign().report()
    assert "w1-stiffness" not in page.html
    assert "w1-load-weight" in page.html
    assert "w1-spikes" in page.html


def test_a_controller_without_diagnostics_is_no_part_of_it(modules):
    put(modules, "pid", "S1", 1.5, shown=False)
    found = modules.report().summary["worlds"][0]["modules"]
    assert "pid / none" not in found["spike_rate"]


def test_errors_by_lap_are_drawn_once_there_are_laps_to_see(modules, quick):
    """Three laps are a table."""
    page = modules.report()
    assert '<figure id="w1-by-lap-position"' in page.html
    assert "by-lap" not in quick.html


def test_no_number_of_the_modules_is_called_nan(modules):
    text = re.sub(r"<(style|script)>.*?</\1>|<[^>]+>", " ", modules.report().html, flags=re.DOTALL)
    assert not re.search(r"\b(nan|None|inf)\b", text)
