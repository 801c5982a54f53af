"""Scripts of runs: several processes write what one writes, and a file that cannot be written is one line."""

import os

import pytest
from torquebench.controllers import InvalidInput
from torquebench.evaluation.report import script_files, write_report


def scripts(folder):
    return {file.name: file.read_bytes() for file in (folder / "runs").iterdir()}


def test_several_processes_write_what_one_writes(shelf, tmp_path, monkeypatch):
    """A report does not depend on the machine that writes it; what no run has any more goes in both ways."""
    shelf.grid(masses=(1.5, 2.5))
    shelf.store.close()
    write_report(shelf.folder, tmp_path / "one", workers=1)
    monkeypatch.setattr(script_files, "MANY", 1)
    (tmp_path / "two" / "runs").mkdir(parents=True)
    (tmp_path / "two" / "runs" / "0123456789abcdef.js").write_text("old", encoding="utf-8")
    write_report(shelf.folder, tmp_path / "two", workers=2)
    assert scripts(tmp_path / "one") == scripts(tmp_path / "two")
    assert len(scripts(tmp_path / "one")) == 5 * 8 * 2


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_is_one_line(shelf, tmp_path):
    """The runs are kept, and so is an old report."""
    shelf.grid(masses=(1.5,))
    shelf.store.close()
    (tmp_path / "closed").mkdir(mode=0o500)
    with pytest.raises(InvalidInput, match="name another folder"):
        write_report(shelf.folder, tmp_path / "closed")
