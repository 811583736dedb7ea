import threading

import numpy as np
import pytest

from gpsec.core import noise
from gpsec.core.kernels import kernel
from gpsec.core.threads import Threads


@kernel
def fill(rows, key, out):
    for row in rows:
        out[row] = noise.normal(key[row], 5, row)


@pytest.fixture(params=[1, 2, 3])
def threads(request):
    pool = Threads(request.param)
    yield pool
    pool.close()


@pytest.mark.parametrize("count", [0, 1, 2, 511, 512, 513, 5000])
def test_result_does_not_depend_on_threads(threads, count):
    key = np.arange(6000, dtype=np.uint64)
    rows = np.random.default_rng(2).permutation(6000)[:count].astype(np.int32)
    out, expected = np.full(6000, -9.0), np.full(6000, -9.0)
    threads.run(fill, rows, key, out)
    fill(rows, key, expected)
    assert out.tobytes() == expected.tobytes()
    assert (out != -9.0).sum() == count


def test_every_row_is_in_one_part(threads):
    parts = []
    rows = np.arange(2000, dtype=np.int32)
    threads.run(lambda part: parts.append((part.copy(), threading.get_ident())), rows)
    assert len(parts) == threads.count
    assert sorted(np.concatenate([part for part, _ in parts]).tolist()) == rows.tolist()
    if threads.count > 1:
        assert threading.get_ident() not in {ident for _, ident in parts}


def test_few_rows_stay_in_the_caller(threads):
    seen = []
    threads.run(lambda part: seen.append(threading.get_ident()), np.arange(2 * Threads.MIN_ROWS - 1, dtype=np.int32))
    assert seen == [threading.get_ident()]


def test_errors_reach_the_caller_and_the_pool_goes_on(threads):
    def refuse(part):
        if 1999 in part:
            raise ZeroDivisionError("by hand")

    rows = np.arange(2000, dtype=np.int32)
    with pytest.raises(ZeroDivisionError, match="by hand"):
        threads.run(refuse, rows)
    out = np.zeros(2000)
    threads.run(fill, rows, rows.astype(np.uint64), out)
    assert (out != 0.0).all()


def test_close_lets_go_of_the_threads():
    before = threading.active_count()
    pool = Threads(3)
    pool.run(lambda part: None, np.arange(3000, dtype=np.int32))
    assert threading.active_count() > before
    pool.close()
    assert threading.active_count() == before
