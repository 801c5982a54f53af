"""Functions as machine code: the interpreter's arithmetic to the bit, compiled once, and never needed."""

import os

import casadi as ca
import numpy as np
import pytest
from torquebench.baselines import compiled_function
from torquebench.baselines.compiled_function import BufferedFunction, compiled_library, find_compiler

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler here")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache."""
    monkeypatch.setattr(compiled_function, "cache_folder", lambda purpose: tmp_path)
    return tmp_path


def waves(scale=3.0):
    """Return a function with a vector, a matrix, and an argument that points share."""
    x, shared = ca.SX.sym("x", 2), ca.SX.sym("shared", 3)
    vector = ca.sin(scale * x) * shared[0] + x * x * shared[1]
    return ca.Function("waves", [x, shared], [vector, ca.horzcat(vector, x, 2 * x)], ["x", "shared"], ["v", "m"])


def filled(points=4):
    """Return the function on its arrays, with arguments."""
    function = BufferedFunction(waves(), points=points, shared=("shared",))
    function.inputs["x"][:] = np.random.default_rng(0).standard_normal((points, 2))
    function.inputs["shared"][:] = 0.3, -1.7, 5.0
    return function


def test_each_point_is_what_a_plain_call_gives(cache):
    """Columns come first in CasADi's buffers: a transposed matrix would pass unseen where it is symmetric."""
    function = filled()
    found = function()
    for point, x in enumerate(function.inputs["x"]):
        vector, matrix = waves()(x, function.inputs["shared"])
        assert found["v"][point] == pytest.approx(vector.full().ravel(), abs=1e-15)
        assert np.transpose(found["m"][point]) == pytest.approx(matrix.full(), abs=1e-15)


@needs_compiler
def test_without_a_compiler_the_same_bits_come_out(cache, monkeypatch):
    """A result must not depend on whether a machine has a compiler."""
    compiled = filled()
    monkeypatch.setattr(compiled_function, "find_compiler", lambda: None)
    interpreted = filled()
    assert (compiled.is_compiled, interpreted.is_compiled) == (True, False)
    for name, array in compiled().items():
        assert np.array_equal(array, interpreted()[name])


@needs_compiler
def test_a_second_use_compiles_nothing(cache, monkeypatch):
    """Every worker of a campaign asks for the same function."""
    first = compiled_library(waves())
    monkeypatch.setattr(compiled_function, "_compile", lambda *arguments: pytest.fail("compiled again"))
    assert compiled_library(waves()) == first


@needs_compiler
def test_another_model_has_another_name(cache):
    """Constants of the model stand in the source: an old library must not be taken for them."""
    assert compiled_library(waves()) != compiled_library(waves(scale=3.0 + 1e-12))
    assert len(list(cache.glob("*.so"))) == 2


@needs_compiler
def test_nothing_but_the_library_is_left_behind(cache):
    """Sources and half-written files would pile up."""
    library = compiled_library(waves())
    assert list(cache.iterdir()) == [library]


def test_a_compiler_that_fails_is_as_good_as_none(cache, tmp_path, monkeypatch):
    """One that lacks its headers or its linker exists, and helps nobody."""
    broken = tmp_path / "broken"
    broken.write_text("#!/bin/sh\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", os.fspath(broken))
    function = filled()
    assert not function.is_compiled
    assert np.isfinite(function()["v"]).all()
