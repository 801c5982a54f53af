"""The run store: one folder with a SQLite file of rows and a content-addressed folder of traces.

A run is written with its twins, or with all repetitions of its chain, in one transaction and after their traces are
in place, so a kill at any moment loses only runs in flight.
"""

import fcntl
import hashlib
import json
import os
import sqlite3
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np

from ..controllers import InvalidInput
from .command import repeating_command
from .result import OK, REFUSED, RunResult
from .specification import CARRIED, RunSpecification
from .trace import decode_trace

SCHEMA = 1
APPLICATION_ID = 0x74627263
"""Marks a SQLite file as a run store: the letters tbrc."""
DATABASE, TRACES, LOCK = "runs.sqlite", "traces", "lock"

_TABLES = """
CREATE TABLE runs (
    address TEXT NOT NULL, role TEXT NOT NULL, repetition INTEGER NOT NULL, specification TEXT NOT NULL,
    status TEXT NOT NULL, cause TEXT NOT NULL, reason TEXT NOT NULL, failed_at REAL, metrics TEXT NOT NULL,
    laps TEXT NOT NULL, diagnostics TEXT NOT NULL, ledger TEXT NOT NULL, counts TEXT NOT NULL, timing TEXT NOT NULL,
    provenance TEXT NOT NULL, trace TEXT NOT NULL,
    PRIMARY KEY (address, role, repetition)
);
CREATE TABLE campaigns (id INTEGER PRIMARY KEY, started TEXT NOT NULL, record TEXT NOT NULL);
"""
_JSON_FIELDS = ("metrics", "laps", "diagnostics", "ledger", "counts", "timing", "provenance")


@dataclass(frozen=True, kw_only=True)
class StoredRun:
    """A row of the store.

    Attributes:
        address: SHA-256 of the specification and of what it used.
        specification: The run.
        result: What it left behind, without its trace.
        trace: Address of its trace, empty if none was kept.
    """

    address: str
    specification: RunSpecification
    result: RunResult
    trace: str

    @property
    def repetition(self) -> int:
        """Number of the repetition: that of the row in a chain of protocol ``carried``, else that of the run."""
        return self.result.repetition if self.specification.protocol == CARRIED else self.specification.repetition

    @property
    def command(self) -> str:
        """The shell command that repeats the run, empty if there is none."""
        return repeating_command(self.specification)

    @property
    def machine(self) -> str:
        """Label of the machine that the result belongs to, empty where any machine gives the same."""
        return str(self.result.provenance.get("machine", ""))


class Store:
    """A run store that is open."""

    def __init__(self, folder: Path, connection: sqlite3.Connection, lock: IO[str] | None) -> None:
        self.folder, self._connection, self._lock = folder, connection, lock

    @classmethod
    def read(cls, folder: Path) -> "Store":
        """Open a store that exists, for reading.

        Raises:
            InvalidInput: If the folder holds no store, a damaged one, or one of a newer schema.
        """
        folder = Path(folder)
        if not (folder / DATABASE).is_file():
            raise InvalidInput("holds no run store", str(folder), "name the --out folder of a campaign")
        return cls(folder, _connect(folder, writable=False), None)

    @classmethod
    def write(cls, folder: Path) -> "Store":
        """Open or create a store for one campaign; it stays locked until it is closed.

        Raises:
            InvalidInput: If the folder is foreign, not writable, of a newer schema, or in use.
        """
        folder = Path(folder)
        _claim(folder)
        lock = _lock(folder)
        try:
            return cls(folder, _connect(folder, writable=True), lock)
        except BaseException:
            lock.close()
            raise

    def close(self) -> None:
        """Close the database and give up the lock."""
        self._connection.close()
        if self._lock is not None:
            self._lock.close()

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def statuses(self) -> dict[str, str]:
        """Return the worst status of every address: ``ok`` and ``refused`` are final, ``failed`` may be tried again."""
        found: dict[str, str] = {}
        for address, status in self._connection.execute("SELECT address, status FROM runs"):
            worse = address not in found or found[address] in (OK, REFUSED)
            found[address] = status if worse else found[address]
        return found

    def put(self, address: str, specification: RunSpecification, results: Sequence[RunResult]) -> None:
        """Write all rows of a run in one transaction; earlier rows of the address are replaced.

        Raises:
            InvalidInput: If the disk is full or the folder is gone; nothing of the run is stored then.
        """
        with _storage_errors(self.folder):
            rows = [_row(address, specification, result, self._keep_trace(result)) for result in results]
            with self._connection:
                self._connection.execute("DELETE FROM runs WHERE address = ?", (address,))
                marks = ", ".join("?" * len(rows[0]))
                self._connection.executemany(f"INSERT INTO runs VALUES ({marks})", rows)

    def put_campaign(self, started: str, record: Mapping[str, object]) -> None:
        """Note a campaign: benchmark, versions, machine, gate."""
        with _storage_errors(self.folder), self._connection:
            text = json.dumps(record, sort_keys=True)
            self._connection.execute("INSERT INTO campaigns (started, record) VALUES (?, ?)", (started, text))

    def campaigns(self) -> list[dict[str, object]]:
        """Return the records of all campaigns that wrote here, oldest first."""
        rows = self._connection.execute("SELECT started, record FROM campaigns ORDER BY id")
        return [{"started": started, **json.loads(record)} for started, record in rows]

    def runs(self) -> list[StoredRun]:
        """Return all rows in the order in which they were written, the newest last."""
        with _storage_errors(self.folder):
            rows = self._connection.execute("SELECT * FROM runs ORDER BY rowid").fetchall()
        return [_stored(row) for row in rows]

    def trace(self, address: str, names: Collection[str] | None = None) -> dict[str, np.ndarray]:
        """Return the arrays of a trace.

        Args:
            address: Its address.
            names: Which arrays, of those that are there; all if None.

        Raises:
            InvalidInput: If the trace is missing or damaged.
        """
        return decode_trace(self._trace_bytes(address), names)

    def merge(self, other: "Store") -> int:
        """Take all rows and traces of another store whose addresses are not finished here.

        Returns:
            Number of addresses taken.

        Raises:
            InvalidInput: If a trace of the other store is missing or damaged, or nothing can be written here.
        """
        finished = {address for address, status in self.statuses().items() if status in (OK, REFUSED)}
        grouped: dict[str, list[StoredRun]] = {}
        for run in other.runs():
            if run.address not in finished:
                grouped.setdefault(run.address, []).append(run)
        for address, runs in grouped.items():
            for run in runs:
                if run.trace:
                    data = other._trace_bytes(run.trace)
                    with _storage_errors(self.folder):
                        self._keep_bytes(run.trace, data)
            rows = [_row(address, run.specification, run.result, run.trace) for run in runs]
            with _storage_errors(self.folder), self._connection:
                self._connection.execute("DELETE FROM runs WHERE address = ?", (address,))
                self._connection.executemany(f"INSERT INTO runs VALUES ({', '.join('?' * len(rows[0]))})", rows)
        known = [json.dumps(record, sort_keys=True) for record in self.campaigns()]
        for record in other.campaigns():
            if json.dumps(record, sort_keys=True) not in known:
                started = str(record.pop("started"))
                self.put_campaign(started, record)
        return len(grouped)

    def _trace_bytes(self, address: str) -> bytes:
        """Read a trace's file and check it against its address."""
        file = self._trace_file(address)
        try:
            data = file.read_bytes()
        except OSError as cause:
            raise InvalidInput("trace is missing", str(file), "run it again with --traces plot") from cause
        if hashlib.sha256(data).hexdigest() != address:
            raise InvalidInput("trace is damaged", str(file), "delete it and run again")
        return data

    def _trace_file(self, address: str) -> Path:
        return self.folder / TRACES / address[:2] / f"{address}.npz"

    def _keep_trace(self, result: RunResult) -> str:
        """Write a trace under the hash of its bytes and return it, empty if there is none."""
        if result.trace is None:
            return ""
        address = hashlib.sha256(result.trace).hexdigest()
        self._keep_bytes(address, result.trace)
        return address

    def _keep_bytes(self, address: str, data: bytes) -> None:
        file = self._trace_file(address)
        if file.is_file() and file.stat().st_size == len(data):
            return
        file.parent.mkdir(parents=True, exist_ok=True)
        descriptor, temporary = tempfile.mkstemp(dir=file.parent, suffix=".tmp")
        try:
            with os.fdopen(descriptor, "wb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(temporary, file)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise


def _claim(folder: Path) -> None:
    """Make the folder, or check that it is a store or empty."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as cause:
        raise InvalidInput("is a file", str(folder), "name a folder with --out") from cause
    except OSError as cause:
        raise InvalidInput(
            f"cannot be made ({cause.strerror})", str(folder), "name another folder with --out"
        ) from cause
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InvalidInput("is not writable", str(folder), "name another folder with --out")
    foreign = [entry.name for entry in folder.iterdir() if entry.name not in (LOCK,)]
    if foreign and not (folder / DATABASE).is_file():
        valid = "name an empty or new folder with --out"
        raise InvalidInput(f"holds other files ({sorted(foreign)[0]}) and no run store", str(folder), valid)


def _lock(folder: Path) -> IO[str]:
    try:
        file = open(folder / LOCK, "a", encoding="utf-8")  # noqa: SIM115 - open as long as the store
    except OSError as cause:
        raise InvalidInput(
            f"is not writable ({cause.strerror})", str(folder), "name another folder with --out"
        ) from cause
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as cause:
        file.close()
        raise InvalidInput("is in use by another campaign", str(folder), "wait for it or name another --out") from cause
    return file


def _connect(folder: Path, *, writable: bool) -> sqlite3.Connection:
    """Open the database and check that it is one of ours and not newer."""
    file = folder / DATABASE
    try:
        connection, application, schema = _open(file, "rwc" if writable else "ro")
    except sqlite3.OperationalError as cause:
        # A writer that was killed leaves a journal, and only one who may write can undo what it had begun.
        if writable or cause.sqlite_errorname != "SQLITE_READONLY_ROLLBACK":
            raise _unreadable(file, cause) from cause
        try:
            connection, application, schema = _open(file, "rw")
        except sqlite3.Error as still:
            raise _unreadable(file, still) from still
    except sqlite3.Error as cause:
        raise _unreadable(file, cause) from cause
    if application != APPLICATION_ID:
        connection.close()
        raise InvalidInput("is not a run store", str(file), "name another folder with --out")
    if schema > SCHEMA:
        connection.close()
        raise InvalidInput(f"has schema {schema}, this version reads up to {SCHEMA}", str(file), "update torquebench")
    return connection


def _open(file: Path, mode: str) -> tuple[sqlite3.Connection, int, int]:
    """Open a database, make its tables if it may be made and is empty, and return its application and schema too."""
    connection = sqlite3.connect(f"{file.resolve().as_uri()}?mode={mode}", uri=True, timeout=30.0)
    try:
        # A kill between making the file and its tables leaves it empty.
        if mode == "rwc" and not connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            marks = f"PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {SCHEMA};"
            connection.executescript(f"BEGIN IMMEDIATE; {marks} {_TABLES} COMMIT;")
        application = connection.execute("PRAGMA application_id").fetchone()[0]
        return connection, application, connection.execute("PRAGMA user_version").fetchone()[0]
    except BaseException:
        connection.close()
        raise


def _unreadable(file: Path, cause: sqlite3.Error) -> InvalidInput:
    return InvalidInput(f"cannot be read ({cause})", str(file), "name another folder with --out")


@contextmanager
def _storage_errors(folder: Path) -> Iterator[None]:
    """Turn what disk and database report into one line."""
    try:
        yield
    except (OSError, sqlite3.Error) as cause:
        raise InvalidInput(f"cannot be used ({cause})", str(folder), "finished runs are kept") from cause


def _row(address: str, specification: RunSpecification, result: RunResult, trace: str) -> tuple[object, ...]:
    texts = (_text(getattr(result, name)) for name in _JSON_FIELDS)
    fixed = (
        address,
        result.role,
        result.repetition,
        specification.as_json(),
        result.status,
        result.cause,
        result.reason,
        result.failed_at,
    )
    return (*fixed, *texts, trace)


def _text(value: object) -> str:
    # NaN is a value of a metric; json writes and reads it.
    return json.dumps(value, sort_keys=True)


def _stored(row: Sequence[object]) -> StoredRun:
    address, role, repetition, specification, status, cause, reason, failed_at, *texts = row
    values = {name: json.loads(str(text)) for name, text in zip(_JSON_FIELDS, texts[:-1], strict=True)}
    return StoredRun(
        address=str(address),
        specification=RunSpecification.from_json(str(specification)),
        result=RunResult(
            role=str(role),
            repetition=repetition,  # type: ignore[arg-type]
            status=str(status),
            cause=str(cause),
            reason=str(reason),
            failed_at=failed_at,  # type: ignore[arg-type]
            **values,
        ),
        trace=str(texts[-1]),
    )
