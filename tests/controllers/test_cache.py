"""What can be computed again lies in a folder that is always writable."""

import os

import pytest
from torquebench.controllers import cache, cache_folder


@pytest.fixture(autouse=True)
def forget():
    """Folders are found once a process; here each test looks anew."""
    cache_folder.cache_clear()
    yield
    cache_folder.cache_clear()


def test_the_variable_names_the_place(monkeypatch, tmp_path):
    """A cluster's home may be read-only or slow."""
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    assert cache_folder("laps").is_relative_to(tmp_path)
    assert cache_folder("laps").name == "laps"
    assert cache_folder("laps").is_dir()


def test_without_it_the_users_cache_folder_is_used(monkeypatch, tmp_path):
    """As the desktop's standard says."""
    monkeypatch.delenv(cache.VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder("laps").is_relative_to(tmp_path / "torquebench")


def test_a_place_that_cannot_be_made_falls_back(monkeypatch, tmp_path):
    """A file stands where the folder should: the run goes on elsewhere."""
    (tmp_path / "taken").write_text("")
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "taken"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "taken"))
    folder = cache_folder("laps")
    assert folder.is_dir()
    assert os.access(folder, os.W_OK)
    assert not folder.is_relative_to(tmp_path)


def test_another_version_has_another_folder(monkeypatch, tmp_path):
    """A compiled kernel of another numba must never be loaded."""
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    first = cache_folder("kernels")
    cache_folder.cache_clear()
    monkeypatch.setattr(cache, "version", lambda name: "99.0")
    assert cache_folder("kernels") != first
