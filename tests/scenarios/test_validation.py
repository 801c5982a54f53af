"""Files of a user: what is wrong, where, and the nearest right choice, in one line."""

from typing import Annotated

import pytest
from pydantic import BeforeValidator, Field
from torquebench.controllers import InvalidInput
from torquebench.scenarios.validation import Names, Number, Numbers, Point3, Record, as_tuple, read_toml, validate


class Spring(Record):
    """A part of a machine."""

    stiffness: Number
    travel: Number = 0.1


class Machine(Record):
    """What a file of this test describes."""

    name: str
    mass: Number = 1.0
    count: int = 1
    size: Point3 = (0.0, 0.0, 0.0)
    gains: Numbers = ()
    tags: Names = ()
    main: Spring | None = None
    springs: Annotated[tuple[Spring, ...], BeforeValidator(as_tuple)] = ()
    spare: dict[str, Spring] = Field(default={})


def test_a_sound_table_becomes_a_record():
    """Lists as tuples, whole numbers as floats where floats are meant."""
    machine = validate(Machine, {"name": "a", "mass": 2, "size": [1, 2.5, 3], "tags": ["x"]}, where="file")
    assert (machine.mass, machine.size, machine.tags) == (2.0, (1.0, 2.5, 3.0), ("x",))
    assert type(machine.mass) is float


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"nam": "a", "name": "b"}, "file: unknown key 'nam'; did you mean 'name'\\?"),
        ({"name": "a", "qqq": 1}, "unknown key 'qqq'; valid keys: name, mass, count, size"),
        ({"name": "a", "main": {"stifness": 1, "stiffness": 1}}, "'main.stifness'; did you mean 'stiffness'"),
        ({"name": "a", "springs": [{"stiffness": 1, "travl": 1}]}, "'springs.0.travl'; did you mean 'travel'"),
        ({"name": "a", "spare": {"left": {"stiffness": 1, "travl": 1}}}, "'spare.left.travl'; did you mean 'travel'"),
        ({}, "file: key 'name' is missing"),
        ({"name": "a", "main": {}}, "key 'main.stiffness' is missing"),
        ({"name": 5}, "name = 5; .*string"),
        ({"name": "a", "mass": "2"}, "mass = '2'; .*number"),
        ({"name": "a", "mass": True}, "mass = True; .*number"),
        ({"name": "a", "mass": float("nan")}, "mass = nan; .*finite"),
        ({"name": "a", "mass": float("inf")}, "mass = inf; .*finite"),
        ({"name": "a", "count": 1.5}, "count = 1.5; .*integer"),
        ({"name": "a", "size": [1, 2]}, "size"),
        ({"name": "a", "gains": [1, "x"]}, "gains.1 = 'x'; .*number"),
        ({"name": "a", "gains": 5}, "gains = 5; .*tuple"),
        ({"name": "a", "tags": [1]}, "tags.0 = 1; .*string"),
    ],
)
def test_the_first_wrong_key_is_named_with_what_would_be_right(table, message):
    """Its path in the file, what came, the nearest key or the kind of value."""
    with pytest.raises(InvalidInput, match=message) as caught:
        validate(Machine, table, where="file")
    assert str(caught.value).startswith("file: ")
    assert "\n" not in str(caught.value)


def test_a_long_value_is_shortened():
    """One line stays one line."""
    with pytest.raises(InvalidInput, match=r"name = \[0, 1, 2.*\.\.\.; ") as caught:
        validate(Machine, {"name": list(range(1000))}, where="file")
    assert len(str(caught.value)) < 150


def test_a_record_is_frozen():
    """What was checked stays what it was."""
    with pytest.raises(Exception, match="frozen"):
        validate(Machine, {"name": "a"}, where="file").mass = 5.0


def test_malformed_toml_names_file_line_and_column(tmp_path):
    """Where the parser stopped."""
    file = tmp_path / "bench.toml"
    file.write_text('name = "a"\nmass = = 2\n')
    with pytest.raises(InvalidInput, match=r"bench.toml: malformed TOML: .*line 2") as caught:
        read_toml(file)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [None, b"\xff\xfe"])
def test_a_file_that_cannot_be_read_is_named(tmp_path, content):
    """Missing, or no text."""
    file = tmp_path / "bench.toml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(InvalidInput, match=r"bench.toml: cannot be read .*expected a TOML file"):
        read_toml(file)


def test_toml_is_read_as_written(tmp_path):
    """No conversion before the check."""
    file = tmp_path / "bench.toml"
    file.write_text("a = 1\n[b]\nc = [1, 2.5]\n")
    assert read_toml(file) == {"a": 1, "b": {"c": [1, 2.5]}}
