"""A Parquet file that is written as a run goes on."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from gpsec.outcomes.tables import whole

# Rows that are held before they are written, as one row group.
ROWS_AT_ONCE = 100_000


class ParquetLog(ABC):
    """Holds rows and writes them in groups; the file has its name only once the log is closed.

    Use it as a context manager: where the block fails, nothing is left behind. A log says what the columns are.

    Attributes:
        path: of the file.
    """

    def __init__(self, path: Path, schema: Any, **options: Any) -> None:
        """Begin the file, with the columns of an Arrow schema; `options` are those of the writer."""
        self.path = path
        self._schema = schema
        self._pending: list[Mapping[str, Any]] = []
        self._count = 0
        self._stack = ExitStack()
        partial = self._stack.enter_context(whole(path))
        self._writer: Any = parquet.ParquetWriter(partial, schema, compression="zstd", **options)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.close()
        else:
            self._writer.close()
            self._stack.__exit__(kind, error, trace)

    @abstractmethod
    def _columns(self, data: Mapping[str, Any]) -> Sequence[Any]:
        """Return the columns as Arrow's arrays, in the order of the schema, of fields that were added."""

    def _hold(self, rows: Mapping[str, Any], count: int) -> None:
        """Hold `count` rows, as fields (count, …) by name; write what is held where there is enough."""
        if count:
            self._pending.append(rows)
            self._count += count
        if self._count >= ROWS_AT_ONCE:
            self._flush()

    def close(self) -> None:
        """Write what is left and give the file its name."""
        self._flush()
        self._writer.close()
        self._stack.close()

    def _flush(self) -> None:
        if not self._count:
            return
        data = {name: np.concatenate([rows[name] for rows in self._pending]) for name in self._pending[0]}
        self._pending, self._count = [], 0
        self._writer.write_table(pa.table(self._columns(data), schema=self._schema))
