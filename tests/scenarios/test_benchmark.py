"""Benchmark files: what they say, what they inherit, and what is said of wrong ones."""

import pytest
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.scenarios.benchmark import benchmark_names, load_benchmark, schedules
from torquebench.scenarios.expansion import expand
from torquebench.scenarios.margins import HOLD, LOOP_RESPONSE, MARGINS
from torquebench.scenarios.perturbation import Perturbation
from torquebench.scenarios.world import cached_plan, cached_robot

SMALL = """
schema = 1
name = "small"
controllers = ["computed_torque"]
trajectories = ["T1", "T6"]
loads = [{ mass = 1.5 }, { mass = 3.5, material = "sand" }]
laps = 1
plant = "pinocchio"
knowledge = ["none", "oracle"]
"""
LAW = """
class Law:
    carry_over = True
    def __init__(self, *, one=0, two=0): pass
    def reset(self, task): pass
    def compute(self, observation, target): pass
"""


@pytest.fixture
def written(tmp_path):
    """Writes a benchmark file and returns its name."""

    def write(text):
        file = tmp_path / "small.toml"
        file.write_text(text)
        return str(file)

    return write


def test_every_benchmark_that_ships_expands_and_names_a_reference_that_runs():
    """A user's first command must not meet a typo of ours."""
    for name in benchmark_names():
        expansion = expand(load_benchmark(name))
        labels = {specification.label for specification in expansion.specifications}
        assert expansion.reference == load_benchmark(name).reference
        assert expansion.reference in labels


def test_events_of_benchmarks_that_ship_fall_on_whole_laps_within_the_run():
    """Old and new load are compared at one phase of the motion, and no twin runs for an event that never comes."""
    found = set()
    for name in benchmark_names():
        for run in expand(load_benchmark(name)).specifications:
            lap = cached_plan(cached_robot(run.robot, run.tool), run.trajectory, run.lead_in).period
            found |= {(event / lap % 1.0, event < run.laps * lap, run.twins) for event in run.schedule.events}
    assert found == {(0.0, True, True)}


def test_benchmarks_that_ship_start_only_cbmc_cold():
    """Without a lead-in the start itself loses runs; scores of other starts must never stand beside each other."""
    cold = {
        (run.controller, run.settings.get("start"))
        for name in benchmark_names()
        for run in expand(load_benchmark(name)).specifications
        if run.lead_in == 0.0
    }
    assert cold - {("cbmc_v3_literal", None)} == {(name, "cold") for name, _ in cold - {("cbmc_v3_literal", None)}}
    assert ("cbmc_v3", "cold") in cold
    assert not {name for name, _ in cold} & {"flexiv_factory", "computed_torque", "pd_oracle", "w_integrator"}


def test_a_benchmark_is_the_product_of_its_lists_at_every_level_that_can_differ(written):
    """2 paths x 2 loads x 2 knowledge levels: nothing is left out and nothing is run twice."""
    runs = expand(load_benchmark(written(SMALL))).specifications
    cells = {(run.trajectory, run.schedule.entries[0][1].mass, run.knowledge) for run in runs}
    assert len(runs) == len(cells) == 8
    assert {run.knowledge for run in runs} == {"none", "oracle"}


def test_a_run_table_says_what_differs_and_inherits_the_rest(written):
    """Two controllers may run differently often in one file."""
    text = (
        SMALL + '[[run]]\nknowledge = ["none"]\n[[run]]\nloads = [{ mass = 2.0, material = "sand" }]\nrepetitions = 3\n'
    )
    runs = expand(load_benchmark(written(text))).specifications
    assert sum(run.knowledge == "none" and run.schedule.entries[0][1].mass != 2.0 for run in runs) == 4
    assert sum(run.schedule.entries[0][1].mass == 2.0 for run in runs) == 2 * 2 * 3


def test_overlapping_run_tables_ask_for_a_run_once(written):
    """The address is the run: asking twice must not double a controller's weight in the means."""
    assert len(expand(load_benchmark(written(SMALL + "[[run]]\n[[run]]\n"))).specifications) == 8


def test_a_schedule_replaces_loads_and_its_events_bring_twins(written):
    """The resilience experiment: 1.5 kg, 3.5 kg at 12 s, 1.5 kg at 24 s."""
    events = "[{ at = 0, mass = 1.5 }, { at = 12, mass = 3.5, material = 'sand' }, { at = 24, mass = 1.5 }]"
    text = SMALL + f"[[run]]\nschedule = {events}\ntwins = true\nlaps = 12\n"
    benchmark = load_benchmark(written(text))
    (history,) = schedules(benchmark.sweeps()[0])
    assert history.events == (12.0, 24.0)
    assert all(run.twins for run in expand(benchmark).specifications)


def test_a_change_reaches_run_tables_too(written):
    """--set laps=2 means the whole benchmark, also where a run table said otherwise."""
    text = SMALL + "[[run]]\nlaps = 5\n"
    changed = load_benchmark(
        written(text), changes=["laps=2", 'trajectories=["T3"]', "settings.computed_torque.bandwidth=25"]
    )
    runs = expand(changed).specifications
    assert {(run.laps, run.trajectory) for run in runs} == {(2, "T3")}
    assert all(run.settings == {"bandwidth": 25} for run in runs)


def test_a_run_table_may_start_cold_with_settings_of_its_own(written):
    """Cold and warm runs of one controller in one file: the same label, other lead-in, settings and addresses."""
    text = (
        SMALL
        + "settings.computed_torque = { bandwidth = 30.0 }\n[[run]]\n"
        + "[[run]]\nlead_in = 0\nsettings.computed_torque = { bandwidth = 25.0 }\n"
    )
    runs = expand(load_benchmark(written(text))).specifications
    assert {(run.lead_in, run.settings["bandwidth"]) for run in runs} == {(1.0, 30.0), (0.0, 25.0)}
    assert len({run.address("code") for run in runs}) == len(runs) == 16
    assert {run.label for run in runs} == {"computed_torque / none", "computed_torque / oracle"}


def test_settings_of_a_run_table_stand_beside_those_of_the_benchmark(tmp_path):
    """A table says what differs and inherits the rest, setting by setting; other tables see nothing of it."""
    file = tmp_path / "laws.py"
    file.write_text(LAW)
    text = SMALL.replace('["computed_torque"]', f'["{file}:Law"]')
    table = f'settings."{file}:Law"'
    text += f"{table} = {{ one = 1, two = 2 }}\n[[run]]\n[[run]]\n{table} = {{ two = 3 }}\n"
    (tmp_path / "small.toml").write_text(text)
    runs = expand(load_benchmark(str(tmp_path / "small.toml"))).specifications
    assert [dict(run.settings) for run in (runs[0], runs[-1])] == [{"one": 1, "two": 2}, {"one": 1, "two": 3}]


def test_a_carried_table_makes_one_run_of_its_repetitions(tmp_path):
    """A chain cannot be cut over processes or shards; without learning there is nothing to carry, which is said."""
    file = tmp_path / "laws.py"
    file.write_text(LAW)
    text = SMALL.replace('["computed_torque"]', f'["{file}:Law"]') + 'repetitions = 3\n[[run]]\nprotocol = "carried"\n'
    (tmp_path / "small.toml").write_text(text)
    runs = expand(load_benchmark(str(tmp_path / "small.toml"))).specifications
    assert {(run.protocol, run.repetition, run.repetitions) for run in runs} == {("carried", 0, 3)}
    assert len(runs) == 2 * 2 * 2
    with pytest.raises(InvalidInput, match="'computed_torque' in protocol 'carried': has no carry_over"):
        expand(load_benchmark(str(tmp_path / "small.toml"), overrides={"controllers": ["computed_torque"]}))


def test_a_change_reaches_settings_of_run_tables_and_other_controllers_drop_them(written):
    """--set is typed for the whole benchmark; --controllers must not stumble over settings of those it leaves out."""
    text = SMALL + "[[run]]\n[[run]]\nlead_in = 0\nsettings.computed_torque = { bandwidth = 25.0 }\n"
    changed = load_benchmark(written(text), changes=["settings.computed_torque.bandwidth=15", "lead_in=0.5"])
    runs = expand(changed).specifications
    assert {(run.lead_in, run.settings["bandwidth"]) for run in runs} == {(0.5, 15)}
    other = load_benchmark(written(text), overrides={"controllers": ["computed_torque_pid"]})
    assert all(run.settings == {} for run in expand(other).specifications)


def test_chosen_controllers_run_where_the_file_has_them_and_others_as_its_last_table_says(written):
    """``--controllers`` must not start a classical law cold because another table of the file does so for another."""
    text = SMALL.replace('controllers = ["computed_torque"]\n', "") + (
        '[[run]]\ncontrollers = ["computed_torque", "compliant"]\nlead_in = 0\n'
        "settings.computed_torque = { bandwidth = 25.0 }\nsettings.compliant = { }\n"
        '[[run]]\ncontrollers = ["computed_torque", "flexiv_factory"]\nknowledge = ["none"]\n'
    )

    def starts(*names):
        runs = expand(load_benchmark(written(text), overrides={"controllers": list(names)})).specifications
        return {(run.controller, run.lead_in) for run in runs}

    assert starts("computed_torque") == {("computed_torque", 0.0), ("computed_torque", 1.0)}
    assert starts("flexiv_factory") == {("flexiv_factory", 1.0)}
    assert starts("computed_torque_pid") == {("computed_torque_pid", 1.0)}
    assert starts("compliant", "computed_torque_pid") == {("compliant", 0.0), ("computed_torque_pid", 1.0)}


def test_a_case_says_what_its_run_table_does_not(written):
    """One table with cases is as many tables, and a change of one case's settings is no change of another's."""
    shared = "[[run]]\nlaps = 2\nlead_in = 0\n"
    cases = [
        "repetitions = 2\nsettings.computed_torque = { bandwidth = 25.0 }\n",
        "laps = 3\nloads = [{ mass = 1.5 }]\n",
    ]
    together = SMALL + shared + "".join(f"[[run.cases]]\n{case}" for case in cases)
    apart = SMALL + shared + cases[0] + shared.replace("laps = 2\n", "") + cases[1]
    for changes in ((), ("settings.computed_torque.bandwidth=15",), ("repetitions=1",)):
        runs = [expand(load_benchmark(written(text), changes=changes)).specifications for text in (together, apart)]
        assert runs[0] == runs[1] and len(runs[0]) > 8


def test_loads_of_a_case_stand_in_for_the_events_of_its_run_table(written):
    """Constant loads and a history exclude each other, so the nearer one counts."""
    history = "[[run]]\nschedule = [{ at = 0, mass = 1.5 }, { at = 1, mass = 3.5, material = 'sand' }]\n"
    runs = expand(
        load_benchmark(written(SMALL + history + "cases = [{}, { loads = [{ mass = 1.5 }] }]\n"))
    ).specifications
    assert {len(run.schedule.entries) for run in runs} == {1, 2}


def test_the_empty_container_has_one_spelling(written):
    """1.5 kg of sand is 1.5 kg without a material: the paper's grid has one such cell, not two."""
    text = SMALL.replace("{ mass = 1.5 }", "{ mass = 1.5 }, { mass = 1.5, material = 'sand' }")
    masses = [run.schedule.entries[0][1] for run in expand(load_benchmark(written(text))).specifications]
    assert sum(load.mass == 1.5 for load in masses) == 4
    assert {load.material for load in masses if load.mass == 1.5} == {"none"}


def test_a_missing_reference_is_replaced_and_noted(written):
    """A report without its reference would have nothing to compare with; silently taking another would mislead."""
    expansion = expand(
        load_benchmark(written(SMALL.replace("laps = 1", 'laps = 1\nreference = "flexiv_factory / none"')))
    )
    assert expansion.reference == "computed_torque / none"
    assert "flexiv_factory / none" in expansion.notes[0]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("laps = 1", "lap = 1", "did you mean 'laps'"),
        ("laps = 1", "laps = 0", "laps = 0"),
        ("laps = 1", 'laps = "two"', "laps = 'two'"),
        ("mass = 1.5", "mess = 1.5", "did you mean 'mass'"),
        ("mass = 1.5", "mass = -1.0", "mass -1 kg"),
        ("mass = 1.5", "mass = 0.5", "below the gripper"),
        ("mass = 1.5", "mass = 2.5", "without a material"),
        ("mass = 3.5", "mass = 300.0", "holds more than 0 and up to"),
        ('"sand"', '"snad"', "did you mean 'sand'"),
        ('"T6"', '"T9"', "unknown trajectory 'T9'"),
        ('"computed_torque"', '"computed_torqe"', "did you mean 'computed_torque'"),
        ('plant = "pinocchio"', 'plant = "pinoccio"', "did you mean 'pinocchio'"),
        ("laps = 1", 'laps = 1\nrobot = "rizon"', "did you mean 'rizon4s'"),
        ("laps = 1", 'laps = 1\ntier = "actuate"', "did you mean 'actuated'"),
        ("laps = 1", 'laps = 1\ntool = "griper"', "did you mean 'gripper'"),
        ('["none", "oracle"]', '["orcale"]', "did you mean 'oracle'"),
        ("laps = 1", "laps = 1\nsettings.computed_torque.width = 3", "width"),
        ("laps = 1", "laps = 1\nsettings.computed_tork.width = 3", "did you mean 'computed_torque'"),
        ('plant = "pinocchio"', "[[run]]\nsettings.computed_tork.width = 3", "did you mean 'computed_torque'"),
        ("laps = 1", "laps = 1\nlead_in = 60", "lead_in = 60 s"),
        ("laps = 1", 'laps = 1\nprotocol = "kept"', "'fresh' or 'carried'"),
        ("laps = 1", 'laps = 1\nprotocol = "carried"', "has no carry_over"),
        ("schema = 1", "schema = 2", "schema = 2"),
        ("laps = 1", "laps = 1 1", "malformed TOML"),
        ('plant = "pinocchio"', "[[run]]\ncases = 3", "cases are no list of tables"),
        ('plant = "pinocchio"', "[[run]]\n[[run.cases]]\nlap = 3", "did you mean 'laps'"),
    ],
)
def test_wrong_input_is_one_line_that_names_what_came_and_what_is_valid(written, old, new, says):
    """A user mends a file from one line; nobody reads a traceback."""
    text = SMALL.replace(old, new, 1)
    with pytest.raises((InvalidInput, UnknownName)) as caught:
        expand(load_benchmark(written(text)))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_unknown_benchmark_names_the_nearest():
    """``torquebench run quik``."""
    with pytest.raises(UnknownName, match="did you mean 'quick'"):
        load_benchmark("quik")


@pytest.mark.parametrize("change", ["laps", "=3", "lapps=3", "settings=3"])
def test_a_change_that_cannot_be_made_says_so(change):
    """--set is typed by hand."""
    with pytest.raises(InvalidInput):
        expand(load_benchmark("quick", changes=[change]))


def test_a_run_table_may_perturb_its_world(written):
    """Whole numbers and decimals alike; the other tables stay nominal."""
    text = SMALL + "[[run]]\n[[run]]\nperturbation = { payload = 1, delay = 3 }\n"
    runs = expand(load_benchmark(written(text))).specifications
    assert {run.perturbation for run in runs} == {Perturbation(), Perturbation(payload=1.0, delay=3)}
    with pytest.raises(InvalidInput, match="perturbation"):
        load_benchmark(written(SMALL + "[[run]]\nperturbation = { paylod = 1 }\n"))
    with pytest.raises(InvalidInput, match="gain = -1"):
        expand(load_benchmark(written(SMALL + "[[run]]\nperturbation = { gain = -1 }\n")))


def test_a_study_is_one_run_of_each_cell(written):
    """A margin search is one row, whatever it takes; its runs are not the benchmark's."""
    text = SMALL + 'studies = ["load_margin", "delay_margin"]\n'
    runs = expand(load_benchmark(written(text))).specifications
    assert len(runs) == 16
    assert {run.study for run in runs} == {"load_margin", "delay_margin"}
    with pytest.raises(UnknownName, match="did you mean 'load_margin'"):
        expand(load_benchmark(written(SMALL + 'studies = ["laod_margin"]\n')))
    with pytest.raises(InvalidInput, match="needs the motion 'hold'"):
        expand(load_benchmark(written(SMALL + 'studies = ["loop_response"]\n')))


def test_robustness_measures_every_margin_and_the_loops_of_every_controller():
    """The null control knows the load, everyone else nothing; the nominal runs stand beside."""
    runs = expand(load_benchmark("robustness")).specifications
    studies = {}
    for run in runs:
        studies.setdefault(run.label, []).append((run.study, run.trajectory))
    expected = [("", "T1"), ("", "T6"), (LOOP_RESPONSE, HOLD)]
    expected += [(margin, path) for margin in MARGINS for path in ("T1", "T6")]
    assert {label: sorted(found) for label, found in studies.items()} == dict.fromkeys(studies, sorted(expected))
    assert {run.controller for run in runs if run.knowledge == "oracle"} == {"pd_oracle"}
    assert {"cbmc_v3 / none", "computed_torque / none", "flexiv_factory / none"} < set(studies)
