"""Hold commits to the rule of CONTRIBUTING.md: ``python .ci/commits.py``, or with ``--message FILE`` as a hook.

Looks at all commits since the rule came; where there is no history of git (an archive, a shallow clone) at nothing.
"""

import argparse
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

# The rule holds for what came after this commit.
SINCE = "446766b909b25b02f9667ef671ab26a3f5e72ca6"
VERBS = ("Add", "Fix", "Change", "Remove", "Rename", "Document", "Measure")
LONGEST = 72
# git writes these subjects itself.
OWN = re.compile(r'Merge |Revert "|fixup! |squash! ')


def main(arguments: list[str] | None = None) -> int:
    """Print a line for each breach; return 1 where there is one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--message", type=Path, metavar="FILE", help="look at this message, not at commits")
    options = parser.parse_args(arguments)
    if options.message:
        text = options.message.read_text(encoding="utf-8")
        messages = {"message": "\n".join(line for line in text.splitlines() if not line.startswith("#"))}
    else:
        messages = dict(_commits(Path.cwd()))
    breaches = [f"{name}: {breach}" for name, message in messages.items() for breach in breaches_of(message)]
    for line in breaches:
        print(line, file=sys.stderr)
    return 1 if breaches else 0


def breaches_of(message: str) -> list[str]:
    """Return what is wrong with a commit message."""
    subject, _, body = message.strip().partition("\n")
    if OWN.match(subject):
        return []
    found = []
    if len(subject) > LONGEST:
        found.append(f"the subject has {len(subject)} characters, expected at most {LONGEST}: {subject}")
    if subject.partition(" ")[0] not in VERBS:
        found.append(f"the subject begins with none of {', '.join(VERBS)}: {subject}")
    if not body.strip():
        found.append(f"no body; expected why: {subject}")
    elif body.partition("\n")[0].strip() or not body.startswith("\n"):
        found.append(f"expected an empty line after the subject: {subject}")
    return found


def _commits(folder: Path) -> Iterator[tuple[str, str]]:
    known = subprocess.run(["git", "cat-file", "-e", f"{SINCE}^{{commit}}"], cwd=folder, capture_output=True)
    if known.returncode:
        return
    asked = ["git", "log", "--no-merges", "--format=%h%x00%B%x01", f"{SINCE}..HEAD"]
    told = subprocess.run(asked, cwd=folder, capture_output=True, text=True, check=True).stdout
    for entry in told.split("\x01"):
        name, _, message = entry.strip().partition("\0")
        if name:
            yield name, message


if __name__ == "__main__":
    sys.exit(main())
