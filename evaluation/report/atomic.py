"""A text file that is there whole or not at all."""

import os
import tempfile
from pathlib import Path


def replace_file(file: Path, text: str) -> None:
    """Write a file under a temporary name and put it in place; what is there already is left alone."""
    if file.is_file() and file.read_bytes() == text.encode():
        return
    descriptor, temporary = tempfile.mkstemp(dir=file.parent, prefix=f".{file.name}.", suffix=".tmp")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
        # A temporary file is private to its owner; a report is made to be shared.
        os.chmod(temporary, 0o644)
        os.replace(temporary, file)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
