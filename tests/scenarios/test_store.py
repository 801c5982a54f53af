"""The run store: whole whatever happens, and never mistaken for something else."""

import hashlib
import os
import signal
import sqlite3
import subprocess
import sys
import textwrap

import numpy as np
import pytest
from torquebench.controllers import InvalidInput
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.store import DATABASE, LOCK, SCHEMA, TRACES, Store
from torquebench.scenarios.trace import decode_trace, encode_trace

RUN = RunSpecification(
    controller="computed_torque",
    trajectory="T6",
    schedule=LoadSchedule(entries=((0.0, Payload(mass=1.5)), (1.0, Payload(mass=3.5, material="sand")))),
    robot="rizon4s",
    plant="pinocchio",
    tier="ideal",
    settings={"bandwidth": 20.0},
)


def result(role="run", *, status="ok", seed=0, **changes):
    """Return a row with a trace."""
    trace = encode_trace({"t": np.arange(5.0), "q": np.full((5, 2), float(seed))})
    metrics = {"run": {"error": {"value": 0.1 + seed, "status": "ok", "unit": "m", "n": 5}}}
    return RunResult(role=role, status=status, **{"metrics": metrics, "trace": trace} | changes)


@pytest.fixture
def folder(tmp_path):
    """Where a store will be."""
    return tmp_path / "out"


@pytest.fixture
def written(folder):
    """A store with one run and its twin, closed."""
    with Store.write(folder) as store:
        store.put("aa11", RUN, [result(), result("constant 1.5 kg", seed=1)])
    return folder


def child(folder, body, *, expected=-signal.SIGKILL):
    """Run a program on the store in a process of its own."""
    program = f"""
import os, signal
import numpy as np
from torquebench.scenarios import store as room
from torquebench.scenarios.store import Store
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.trace import encode_trace
from torquebench.scenarios.specification import RunSpecification
RUN = RunSpecification.from_json({RUN.as_json()!r})
FOLDER = {str(folder)!r}
def die(*_, **__): os.kill(os.getpid(), signal.SIGKILL)
""" + textwrap.dedent(body)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == expected, done.stderr


def test_what_was_put_is_read_back_the_same(written):
    """Specification, result, trace."""
    with Store.read(written) as store:
        run, twin = sorted(store.runs(), key=lambda row: row.result.role, reverse=True)
        assert run.specification == RUN
        assert run.result.role == "run"
        assert twin.result.role == "constant 1.5 kg"
        assert run.result.metrics == result().metrics
        assert np.array_equal(store.trace(twin.trace)["q"], np.ones((5, 2)))


def test_not_a_number_is_a_value(folder):
    """A metric that has none is NaN in the row, not a crash of the coordinator."""
    metrics = {"run": {"error": {"value": float("nan"), "status": "undefined"}}}
    with Store.write(folder) as store:
        store.put("aa11", RUN, [result(metrics=metrics)])
        (row,) = store.runs()
    assert np.isnan(row.result.metrics["run"]["error"]["value"])


def test_a_failed_run_is_a_row_like_any_other(folder):
    """With what ended it, and when."""
    with Store.write(folder) as store:
        store.put(
            "aa11", RUN, [result(status="failed", cause="divergence", reason="joint 7", failed_at=0.25, trace=None)]
        )
        (row,) = store.runs()
    assert (row.result.status, row.result.cause, row.result.failed_at, row.trace) == ("failed", "divergence", 0.25, "")


@pytest.mark.parametrize(
    ("statuses", "worst"),
    [
        (("ok", "ok"), "ok"),
        (("ok", "failed"), "failed"),
        (("failed", "ok"), "failed"),
        (("refused", "failed"), "failed"),
    ],
)
def test_the_status_of_an_address_is_its_worst(folder, statuses, worst):
    """A run with a failed twin may be tried again as a whole."""
    with Store.write(folder) as store:
        store.put("aa11", RUN, [result(f"role {i}", status=status) for i, status in enumerate(statuses)])
        assert store.statuses() == {"aa11": worst}


def test_a_second_try_replaces_the_first(written):
    """All rows of the address at once."""
    with Store.write(written) as store:
        store.put("aa11", RUN, [result(seed=5)])
        (row,) = store.runs()
    assert row.result.metrics["run"]["error"]["value"] == 5.1


def test_equal_traces_are_kept_once_under_the_hash_of_their_bytes(written):
    """Content-addressed, with two letters of fan-out."""
    with Store.write(written) as store:
        store.put("bb22", RUN, [result()])
    files = sorted(path for path in (written / TRACES).rglob("*") if path.is_file())
    assert len(files) == 2
    for file in files:
        assert file.stem == hashlib.sha256(file.read_bytes()).hexdigest()
        assert file.parent.name == file.stem[:2]


def test_the_same_arrays_are_the_same_bytes():
    """An archive with time stamps would change its address from run to run."""
    arrays = {"t": np.arange(3.0), "q": np.eye(3), "label": np.array([1, 2])}
    assert encode_trace(arrays) == encode_trace(arrays)
    found = decode_trace(encode_trace(arrays))
    assert set(found) == set(arrays)
    assert all(np.array_equal(found[name], arrays[name]) for name in arrays)


def test_campaigns_are_noted_in_order(folder):
    """Benchmark, versions, gate: what a page cites."""
    with Store.write(folder) as store:
        store.put_campaign("2024-01-01", {"benchmark": "quick"})
        store.put_campaign("2024-01-02", {"benchmark": "paper", "gate": [1.0]})
    with Store.read(folder) as store:
        assert store.campaigns() == [
            {"started": "2024-01-01", "benchmark": "quick"},
            {"started": "2024-01-02", "benchmark": "paper", "gate": [1.0]},
        ]


def test_a_kill_between_trace_and_row_leaves_the_store_whole(written):
    """The trace is there, the row is not: that run is done again, nothing else."""
    child(
        written,
        """
        store = Store.write(FOLDER)
        room._row = die
        store.put("cc33", RUN, [RunResult(role="run", status="ok", trace=encode_trace({"t": np.arange(9.0)}))])
        """,
    )
    with Store.write(written) as store:
        assert store.statuses() == {"aa11": "ok"}
        assert len(store.runs()) == 2
        store.put("cc33", RUN, [result(trace=encode_trace({"t": np.arange(9.0)}))])
        assert store.statuses() == {"aa11": "ok", "cc33": "ok"}


@pytest.mark.parametrize("open_again", [Store.read, Store.write], ids=["reader", "writer"])
def test_a_kill_within_a_transaction_loses_that_run_only(written, open_again):
    """Rows are half written, the journal lies beside them: a report must read the store as it was before."""
    child(
        written,
        """
        store = Store.write(FOLDER)
        store._connection.execute("DELETE FROM runs")
        text = "x" * 1_000_000
        for i in range(9):
            row = (str(i), "run", 0, "{}", "ok", "", "", None, text, "{}", "{}", "[]", "{}", "{}", "{}", "")
            store._connection.execute(f"INSERT INTO runs VALUES ({', '.join('?' * len(row))})", row)
        die()
        """,
    )
    assert (written / f"{DATABASE}-journal").stat().st_size > 0
    with open_again(written) as store:
        assert store.statuses() == {"aa11": "ok"}
        assert len(store.runs()) == 2


def test_a_kill_while_the_store_is_made_leaves_a_folder_that_can_be_used(folder):
    """Between the file and its tables."""
    child(
        folder,
        """
        room._TABLES = room._TABLES + "SELECT die();"
        import sqlite3
        plain = sqlite3.connect
        def connect(*args, **options):
            connection = plain(*args, **options)
            connection.create_function("die", 0, die)
            return connection
        room.sqlite3.connect = connect
        Store.write(FOLDER)
        """,
    )
    assert (folder / DATABASE).exists()
    with Store.write(folder) as store:
        store.put("aa11", RUN, [result()])
        assert store.statuses() == {"aa11": "ok"}


def test_an_empty_database_is_a_store_to_be(folder):
    """A file of no bytes is what such a kill leaves at the earliest."""
    folder.mkdir()
    (folder / DATABASE).touch()
    with Store.write(folder) as store:
        assert store.runs() == []
    assert Store.read(folder).statuses() == {}


def test_a_kill_leaves_no_lock(written):
    """The system lets go of it with the process."""
    child(written, "store = Store.write(FOLDER); die()")
    Store.write(written).close()


def test_two_campaigns_cannot_write_one_store(written):
    """The second is told; readers are welcome."""
    with Store.write(written):
        with pytest.raises(InvalidInput, match="is in use by another campaign; wait for it or name another --out"):
            Store.write(written)
        with Store.read(written) as reader:
            assert len(reader.runs()) == 2
    Store.write(written).close()


def test_a_foreign_folder_is_not_touched(tmp_path):
    """Somebody's home, by a slip of --out."""
    (tmp_path / "thesis.tex").write_text("x")
    with pytest.raises(InvalidInput, match=r"holds other files \(thesis.tex\) and no run store"):
        Store.write(tmp_path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_file_is_no_folder(tmp_path):
    """One line."""
    (tmp_path / "out").write_text("x")
    with pytest.raises(InvalidInput, match="out: is a file; name a folder with --out"):
        Store.write(tmp_path / "out")
    with pytest.raises(InvalidInput, match="out/sub: cannot be made"):
        Store.write(tmp_path / "out" / "sub")


@pytest.mark.parametrize("make", [lambda folder: None, lambda folder: folder.mkdir()], ids=["missing", "empty"])
def test_a_folder_without_a_store_cannot_be_read(folder, make):
    """And reading makes none."""
    make(folder)
    with pytest.raises(InvalidInput, match="holds no run store; name the --out folder of a campaign"):
        Store.read(folder)
    assert not (folder / DATABASE).exists()


@pytest.mark.parametrize("open_it", [Store.read, Store.write], ids=["reader", "writer"])
def test_another_programs_database_is_refused_untouched(folder, open_it):
    """Its name is no proof."""
    folder.mkdir()
    with sqlite3.connect(folder / DATABASE) as other:
        other.execute("CREATE TABLE recipes (name TEXT)")
    before = (folder / DATABASE).read_bytes()
    with pytest.raises(InvalidInput, match=r"runs.sqlite: is not a run store"):
        open_it(folder)
    assert (folder / DATABASE).read_bytes() == before


@pytest.mark.parametrize("open_it", [Store.read, Store.write], ids=["reader", "writer"])
def test_a_damaged_database_is_one_line(folder, open_it):
    """Not sqlite's traceback; and the lock is given back."""
    folder.mkdir()
    (folder / DATABASE).write_bytes(b"this is not a database, whatever its name says" * 50)
    for _ in range(2):
        with pytest.raises(InvalidInput, match=r"runs.sqlite: cannot be read .*not a database") as caught:
            open_it(folder)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("open_it", [Store.read, Store.write], ids=["reader", "writer"])
def test_a_store_of_a_newer_version_is_refused(written, open_it):
    """Both numbers, and what to do."""
    with sqlite3.connect(written / DATABASE) as database:
        database.execute(f"PRAGMA user_version = {SCHEMA + 1}")
    database.close()
    with pytest.raises(
        InvalidInput, match=f"has schema {SCHEMA + 1}, this version reads up to {SCHEMA}; update torquebench"
    ):
        open_it(written)


def test_a_damaged_trace_is_found_by_its_address(written):
    """One flipped bit."""
    with Store.read(written) as store:
        address = store.runs()[0].trace
        file = written / TRACES / address[:2] / f"{address}.npz"
        data = bytearray(file.read_bytes())
        data[len(data) // 2] ^= 1
        file.write_bytes(data)
        with pytest.raises(InvalidInput, match="trace is damaged; delete it and run again"):
            store.trace(address)
        file.unlink()
        with pytest.raises(InvalidInput, match="trace is missing; run it again"):
            store.trace(address)


def test_merging_takes_what_is_not_finished_here(tmp_path):
    """Shards of a cluster become one store; finished rows stay, failed ones are replaced."""
    with Store.write(tmp_path / "one") as one, Store.write(tmp_path / "two") as two:
        one.put("aa", RUN, [result(seed=1)])
        one.put("bb", RUN, [result(status="failed", trace=None)])
        two.put("aa", RUN, [result(seed=2)])
        two.put("bb", RUN, [result(seed=3)])
        two.put("cc", RUN, [result(seed=4), result("constant 1.5 kg", seed=5)])
        two.put_campaign("2024-01-01", {"benchmark": "quick", "shard": "2/2"})
        assert one.merge(two) == 2
        values = {(row.address, row.result.role): row.result.metrics["run"]["error"]["value"] for row in one.runs()}
        assert values == {("aa", "run"): 1.1, ("bb", "run"): 3.1, ("cc", "run"): 4.1, ("cc", "constant 1.5 kg"): 5.1}
        for row in one.runs():
            assert one.trace(row.trace)["q"][0, 0] + 0.1 == row.result.metrics["run"]["error"]["value"]
        assert one.merge(two) == 0
        assert len(one.campaigns()) == 1


def test_merging_a_store_with_a_lost_trace_is_one_line(tmp_path):
    """And takes nothing of that run."""
    with Store.write(tmp_path / "one") as one, Store.write(tmp_path / "two") as two:
        two.put("aa", RUN, [result()])
        for file in (tmp_path / "two" / TRACES).rglob("*.npz"):
            file.unlink()
        with pytest.raises(InvalidInput, match="trace is missing"):
            one.merge(two)
        assert one.statuses() == {}


def test_a_full_disk_stores_nothing_of_the_run(written, monkeypatch):
    """One line, and what was finished is kept."""

    def full(*_):
        raise OSError(28, "No space left on device")

    with Store.write(written) as store:
        monkeypatch.setattr(os, "replace", full)
        with pytest.raises(InvalidInput, match=r"No space left on device.*finished runs are kept"):
            store.put("cc33", RUN, [result(seed=7)])
        assert store.statuses() == {"aa11": "ok"}
    assert not list((written / TRACES).rglob("*.tmp"))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_refused_and_can_be_read(written):
    """Somebody else's results."""
    written.chmod(0o500)
    try:
        with pytest.raises(InvalidInput, match="is not writable"):
            Store.write(written)
        assert len(Store.read(written).runs()) == 2
    finally:
        written.chmod(0o700)


def test_only_the_lock_may_lie_there_before(folder):
    """A campaign that was killed before it made its database."""
    folder.mkdir()
    (folder / LOCK).touch()
    Store.write(folder).close()
    assert (folder / DATABASE).is_file()
