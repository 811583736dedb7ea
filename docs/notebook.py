"""Writes docs/analysis.ipynb from docs/analysis.md, cell by cell: `python docs/notebook.py`. A test holds it."""

import json
import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent
_BLOCK = re.compile(r"```python\n(.*?)```\n?", re.DOTALL)


def notebook(page: str) -> str:
    """Return the notebook of a page: its Python blocks as code, all else as text. It holds no results."""
    cells = []
    for place, part in enumerate(_BLOCK.split(page)):
        if not part.strip():
            continue
        lines = part.strip().splitlines(keepends=True)
        cell: dict[str, Any] = {"id": f"cell-{place}", "metadata": {}, "source": lines}
        if place % 2:
            cell |= {"cell_type": "code", "execution_count": None, "outputs": []}
        else:
            cell["cell_type"] = "markdown"
        cells.append(dict(sorted(cell.items())))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    (DOCS / "analysis.ipynb").write_text(notebook((DOCS / "analysis.md").read_text("utf-8")), "utf-8")
