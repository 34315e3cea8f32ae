"""Compiled code is kept for later runs, whoever else keeps it at the same time."""

import threading
from pathlib import Path

from urdf2mbs_simulate.equations import write_to_cache


def test_threads_that_keep_one_file_all_succeed(tmp_path: Path) -> None:
    start = threading.Barrier(8)
    failures: list[Exception] = []

    def keep_often(number: int) -> None:
        start.wait()
        try:
            for _ in range(20):
                write_to_cache(tmp_path / "cache" / "code.so", b"%d" % number * 10**5)
        except OSError as error:
            failures.append(error)

    threads = [threading.Thread(target=keep_often, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []
    assert [file.name for file in (tmp_path / "cache").iterdir()] == ["code.so"]
