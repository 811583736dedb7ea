"""One damaged input: it is made from its number, so that the number is all that need be kept."""

import io
import os
import re
import shutil
import traceback
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from random import Random

from gpsec.core.errors import GpsecError

from .mutators import several
from .readers import Reader

ALLOWED = (0, 1, 2)
# Escape sequences and marks that turn the direction of writing may not reach a terminal.
UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
WORDS_OF_A_FAULT = ("Traceback (most recent call last)", "fault in gpsec")


def lay_out(name: str, reader: Reader, number: int, folder: Path) -> None:
    """Write the files of a reader, damaged as `number` says; number 0 leaves them as they are."""
    draw = Random(f"{name}/{number}")
    chosen = draw.choice(sorted(reader.damaged))
    for path, content in reader.files.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        damaged = number and path == chosen
        target.write_bytes(several(reader.damaged[path], content, draw) if damaged else content)


def attempt(name: str, reader: Reader, number: int, folder: Path) -> str:
    """Let a reader read a damaged input in `folder`; return what was wrong with that, empty where nothing was."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    lay_out(name, reader, number, folder)
    said = io.StringIO()
    before = Path.cwd()
    os.chdir(folder)
    try:
        with redirect_stdout(said), redirect_stderr(said):
            status = reader.read()
    except GpsecError as error:
        said.write(str(error))
        status = 2
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else 1
    except (Exception, KeyboardInterrupt):
        return traceback.format_exc()
    finally:
        os.chdir(before)
    text = said.getvalue()
    if status not in ALLOWED:
        return f"exit status {status}: {text}"
    if any(words in text for words in WORDS_OF_A_FAULT):
        return text
    if status and not text.strip():
        return f"exit status {status} without a word"
    if found := UNPRINTABLE.search(text):
        return f"prints {found.group()!r}: {text!r}"
    if number == 0 and status:
        return f"refuses what is in order: {text}"
    return ""
