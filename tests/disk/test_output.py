"""Files are written whole, into what the user has put there, and never over somebody's work."""

import os
import stat
import sys
import threading
from pathlib import Path

import pytest

from urdf2mbs.disk.record import RECORD, is_ours
from urdf2mbs.engine.output import write_files
from urdf2mbs.messages.diagnostics import ConfigError

posix = pytest.mark.skipif(sys.platform == "win32", reason="links, modes and pipes of POSIX")


def names(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir() if file.name != RECORD)


def mode(file: Path) -> int:
    return stat.S_IMODE(file.stat().st_mode)


def test_what_we_wrote_is_ours_until_somebody_changes_it(tmp_path: Path) -> None:
    file, second = tmp_path / "a" / "b" / "c.csv", tmp_path / "a" / "b" / "d.csv"
    write_files({file: b"1\n", second: b"2\n"})
    write_files({file: b"3\n"})
    write_files({file: b"3\n"})
    assert (file.parent / RECORD).read_text().count("\n") == 3
    assert (file.read_bytes(), second.read_bytes()) == (b"3\n", b"2\n")
    assert names(file.parent) == ["c.csv", "d.csv"]
    file.write_bytes(b"mine\n")
    assert not is_ours(file)
    for other in ({file: b"4\n"}, {second: b"5\n", file: b"4\n"}):
        with pytest.raises(ConfigError, match=r"c\.csv' was edited since") as caught:
            write_files(other)
        assert caught.value.code == "output-not-ours"
        assert (file.read_bytes(), second.read_bytes()) == (b"mine\n", b"2\n")
    write_files({file: b"mine\n"})  # as it is
    file.write_bytes(b"yours\n")
    write_files({file: b"4\n"}, force=True)
    assert is_ours(file)


def test_a_file_of_others_stays(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"mine")
    with pytest.raises(ConfigError, match="is not known to urdf2mbs"):
        write_files({tmp_path / "a": b"new"})
    (tmp_path / "a").write_bytes(b"")  # which holds nothing to lose
    write_files({tmp_path / "a": b"new"})
    assert (tmp_path / "a").read_bytes() == b"new"


def test_line_ends_that_git_converts_are_no_change(tmp_path: Path) -> None:
    write_files({tmp_path / "a.c": b"int x;\nint y;\n"})
    for file in (tmp_path / "a.c", tmp_path / RECORD):
        file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    assert is_ours(tmp_path / "a.c")
    write_files({tmp_path / "a.c": b"int z;\n"})
    (tmp_path / "a.c").write_bytes(b"int zz;\n")
    assert not is_ours(tmp_path / "a.c")


def test_what_holds_the_work_of_people_is_not_ours(tmp_path: Path) -> None:
    file = tmp_path / "a.mbs"
    file.write_bytes(b"edited")
    write_files({file: b"merged"}, replaces={file: b"edited"})
    assert file.read_bytes() == b"merged"
    assert not is_ours(file)
    with pytest.raises(ConfigError, match="is not known"):
        write_files({file: b"other"}, replaces={file: b"edited"})


def test_a_starter_belongs_to_the_user(tmp_path: Path) -> None:
    file = tmp_path / "user.py"
    for text in (b"first", b"second"):
        write_files({}, once={file: text})
        assert file.read_bytes() == text
    file.write_bytes(b"mine")
    write_files({}, once={file: b"third"}, force=True)
    assert file.read_bytes() == b"mine"


def test_what_fits_no_more_goes_unless_somebody_changed_it(tmp_path: Path) -> None:
    files = {tmp_path / name: b"1" for name in ("a", "b", "c")}
    write_files(files)
    (tmp_path / "b").write_bytes(b"mine")
    write_files({tmp_path / "c": b"2"}, obsolete=[*files, tmp_path / "none"])
    assert names(tmp_path) == ["b", "c"]


@posix
def test_the_mode_is_that_of_the_file_before_or_of_any_new_file(tmp_path: Path) -> None:
    for mask in (0o022, 0o077, 0o002):
        old = os.umask(mask)
        try:
            write_files({tmp_path / f"{mask}": b""})
            (tmp_path / f"{mask}.plain").touch()
        finally:
            os.umask(old)
        assert mode(tmp_path / f"{mask}") == mode(tmp_path / f"{mask}.plain")
    for bits in (0o600, 0o755, 0o664):
        (tmp_path / "a").touch()
        (tmp_path / "a").chmod(bits)
        write_files({tmp_path / "a": b"%d" % bits})
        assert mode(tmp_path / "a") == bits


@posix
@pytest.mark.parametrize("relative", [True, False])
def test_a_link_is_followed(tmp_path: Path, relative: bool) -> None:
    (tmp_path / "there").mkdir()
    real, link = tmp_path / "there" / "real", tmp_path / "link"
    link.symlink_to(Path("there", "real") if relative else real)
    for data in (b"1", b"2"):
        write_files({link: data})
        assert link.is_symlink()
        assert real.read_bytes() == data
    write_files({}, obsolete=[link])
    assert not link.is_symlink()


@posix
def test_a_pipe_and_a_device_are_written_to(tmp_path: Path) -> None:
    pipe, null = tmp_path / "pipe", tmp_path / "null"
    os.mkfifo(pipe)
    null.symlink_to("/dev/null")  # a mistake here replaces the link, and not the device
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
    reader.start()
    write_files({pipe: b"through", null: b"gone"})
    reader.join()
    assert read == [b"through"]
    assert pipe.is_fifo()
    assert null.is_symlink()
    assert Path("/dev/null").is_char_device()


def test_nothing_is_replaced_where_one_has_no_place(tmp_path: Path) -> None:
    write_files({tmp_path / "a": b"old"})
    (tmp_path / "b").mkdir()
    (tmp_path / "c").touch()
    for bad in (tmp_path / "b", tmp_path / "c" / "d"):
        with pytest.raises(ConfigError, match="cannot write") as caught:
            write_files({tmp_path / "a": b"new", bad: b"new"})
        assert caught.value.code == "output-unwritable"
        assert (tmp_path / "a").read_bytes() == b"old"
        assert names(tmp_path) == ["a", "b", "c"]


@posix
def test_a_file_that_may_not_be_written_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_files({tmp_path / "a": b"old"})
    monkeypatch.setattr(os, "access", lambda *_: False)  # as root, all may be
    with pytest.raises(ConfigError, match="Permission denied"):
        write_files({tmp_path / "a": b"new"})
    assert (tmp_path / "a").read_bytes() == b"old"


def test_threads_that_write_one_output_all_succeed(tmp_path: Path) -> None:
    """Each file is that of one of the threads, none fails, and nothing is left beside it."""
    start = threading.Barrier(8)
    failures: list[Exception] = []

    def write_often(number: int) -> None:
        start.wait()
        try:
            for _ in range(5):
                write_files({tmp_path / name: b"%d" % number * 10**5 for name in ("a", "b")})
        except Exception as error:
            failures.append(error)

    threads = [threading.Thread(target=write_often, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []
    assert names(tmp_path) == ["a", "b"]
    for name in ("a", "b"):
        data = (tmp_path / name).read_bytes()
        assert len(data) == 10**5
        assert len(set(data)) == 1
        assert is_ours(tmp_path / name)


def test_a_record_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / RECORD).mkdir()
    with pytest.raises(ConfigError, match=rf"cannot write '.*{RECORD}'") as caught:
        write_files({tmp_path / "a.mbs": b"1", tmp_path / "a.mbs.base": b"2"})
    assert caught.value.code == "output-unwritable"
    assert names(tmp_path) == []


def test_a_record_that_cannot_be_read_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_files({tmp_path / "a": b"1"})
    read_bytes = Path.read_bytes

    def refuse_record(path: Path) -> bytes:
        if path.name == RECORD:
            raise PermissionError(13, "Permission denied", str(path))
        return read_bytes(path)

    monkeypatch.setattr(Path, "read_bytes", refuse_record)  # as root, all may be read
    with pytest.raises(ConfigError, match=rf"cannot read '.*{RECORD}': Permission denied"):
        write_files({tmp_path / "a": b"2"})


def test_long_names_that_begin_alike_are_two_files(tmp_path: Path) -> None:
    files = {tmp_path / f"{'long' * 20}.{ending}": ending.encode() for ending in ("c", "h")}
    write_files(files)
    assert {path: path.read_bytes() for path in tmp_path.glob("long*")} == files
