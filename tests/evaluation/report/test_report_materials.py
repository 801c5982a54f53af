"""The report's table of two materials: a row for each controller, its difference with an interval."""

import json
from dataclasses import replace

from torquebench.scenarios.loads import LoadSchedule, Payload

SHIFT = {"T1": 0.9999, "T2": 1.0004, "T3": 1.0001}


def poured(shelf):
    """Two controllers with sand and with water, whose effect is a few parts in ten thousand."""
    scales = {("flexiv_factory", "none"): 17.2e-3, ("computed_torque", "none"): 3.1e-3}
    for (controller, knowledge), size in scales.items():
        for trajectory, shift in SHIFT.items():
            for mass in (1.5, 2.5, 3.5):
                sand = shelf.specification(controller, knowledge, trajectory, mass)
                result = shelf.result(sand, size, "slow")
                shelf.put(sand, result)
                if mass > 1.5:
                    water = LoadSchedule.constant(Payload(mass=mass, material="water"))
                    run = json.loads(json.dumps(result.metrics))
                    for values in run.values():
                        for value in values.values():
                            value["value"] *= shift
                    shelf.put(replace(sand, schedule=water), replace(result, metrics=run))
    return shelf.campaign().report()


def test_water_against_sand_has_a_row_for_each_controller(shelf):
    """Means, difference and ratio, the interval over trajectories below."""
    page = poured(shelf)
    (world,) = page.summary["worlds"]
    found = [entry for entry in world["materials"] if entry["metric"] == "tcp_position_error_mean"]
    assert {entry["controller"] for entry in found} == {"flexiv_factory / none", "computed_torque / none"}
    for entry in found:
        water, sand = entry["means"]
        assert abs(entry["difference"] - (water - sand)) < 1e-12
        assert entry["interval"]["low"] < entry["difference"] < entry["interval"]["high"]
        assert entry["ratio"]["n_pairs"] == 9
    assert "Mean position error: water against sand at the same masses, run window" in page.html
    assert 'id="w1-water-sand-orientation"' in page.html
    factory = next(entry for entry in found if entry["controller"].startswith("flexiv_factory"))
    shown = f"{1e3 * abs(factory['difference']):.2g}"
    table = page.html.split('id="w1-water-sand-position"')[1].split("</table>")[0]
    assert shown in table and " to " in table


def test_a_difference_far_below_a_micrometre_is_shown_with_its_digits(shelf):
    """'0.000 mm' would hide that it was measured."""
    page = poured(shelf)
    table = page.html.split('id="w1-water-sand-position"')[1].split("</table>")[0]
    assert "0.000<" not in table


def test_one_material_has_no_table(quick):
    """And no heading without one."""
    assert quick.summary["worlds"][0]["materials"] == []
    assert "water against" not in quick.html
