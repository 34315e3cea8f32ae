"""Files are written whole, all or none, and into what the user has put there."""

from __future__ import annotations

import os
import stat
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from urdf2mbs.disk import output
from urdf2mbs.disk.output import write_files as write_ours
from urdf2mbs.disk.seal import RECORD
from urdf2mbs.messages.diagnostics import ConfigError

posix = pytest.mark.skipif(sys.platform == "win32", reason="links, modes and pipes of POSIX")


def write_files(files: dict[Path, bytes]) -> None:
    """Whose the files are is not asked here: see test_seal.py."""
    write_ours(files, force=True)


def names(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir() if file.name != RECORD)


def mode(file: Path) -> int:
    return stat.S_IMODE(file.stat().st_mode)


def test_new_folders_and_files(tmp_path: Path) -> None:
    file = tmp_path / "a" / "b" / "c.mbs"
    write_files({file: b"one"})
    assert file.read_bytes() == b"one"
    assert names(file.parent) == ["c.mbs"]


@posix
def test_a_new_file_has_the_mode_that_any_new_file_has(tmp_path: Path) -> None:
    for mask in (0o022, 0o077, 0o002):
        old = os.umask(mask)
        try:
            write_files({tmp_path / f"{mask}": b""})
            (tmp_path / f"{mask}.plain").touch()
        finally:
            os.umask(old)
        assert mode(tmp_path / f"{mask}") == mode(tmp_path / f"{mask}.plain")


@posix
@pytest.mark.parametrize("bits", [0o600, 0o640, 0o755, 0o664])
def test_the_mode_is_kept(tmp_path: Path, bits: int) -> None:
    file = tmp_path / "a"
    file.touch()
    file.chmod(bits)
    write_files({file: b"new"})
    assert (mode(file), file.read_bytes()) == (bits, b"new")


@posix
@pytest.mark.parametrize("relative", [True, False])
def test_a_link_is_followed(tmp_path: Path, relative: bool) -> None:
    (tmp_path / "there").mkdir()
    real = tmp_path / "there" / "real"
    for content in (None, b"old"):
        if content is not None:
            real.write_bytes(content)
        link = tmp_path / f"link{content!r}"
        link.symlink_to(Path("there", "real") if relative else real)
        write_files({link: b"new"})
        assert link.is_symlink()
        assert real.read_bytes() == b"new"
        real.unlink()


@posix
def test_two_names_of_one_file(tmp_path: Path) -> None:
    (tmp_path / "a").touch()
    (tmp_path / "b").symlink_to("a")
    write_files({tmp_path / "a": b"1", tmp_path / "b": b"2"})
    assert names(tmp_path) == ["a", "b"]
    assert (tmp_path / "a").read_bytes() == b"2"


@posix
def test_a_pipe_is_written_to(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
    reader.start()
    write_files({pipe: b"through"})
    reader.join()
    assert read == [b"through"]
    assert pipe.is_fifo()


@posix
def test_a_device_stays(tmp_path: Path) -> None:
    # by a link, so that a mistake here replaces the link and not the machine's device
    null = tmp_path / "null"
    null.symlink_to("/dev/null")
    write_files({null: b"gone"})
    assert Path("/dev/null").is_char_device()
    assert null.is_symlink()


@pytest.mark.parametrize("fails", [0, 1, 2])
@pytest.mark.parametrize("kind", [OSError, KeyboardInterrupt])
@pytest.mark.parametrize("links", [True, False])
def test_a_rename_that_fails_undoes_those_before(
    tmp_path: Path, fails: int, kind: type[BaseException], links: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    files = {tmp_path / name: b"new" for name in ("a", "b", "c")}
    (tmp_path / "a").write_bytes(b"old")
    (tmp_path / "c").write_bytes(b"old")
    replace = Path.replace
    renamed: list[Path] = []

    def failing(self: Path, target: Path) -> Any:
        if self.suffix == ".part":
            renamed.append(target)
            if len(renamed) == fails + 1:
                raise kind(28, "No space left on device")
        return replace(self, target)

    def no_link(*_: Any) -> None:
        raise OSError

    monkeypatch.setattr(Path, "replace", failing)
    if not links:
        monkeypatch.setattr(os, "link", no_link)
    with pytest.raises(ConfigError if kind is OSError else kind):
        write_files(files)
    assert names(tmp_path) == ["a", "c"]
    assert (tmp_path / "a").read_bytes() == b"old"
    assert (tmp_path / "c").read_bytes() == b"old"


def test_nothing_is_replaced_where_one_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old")
    (tmp_path / "b").mkdir()
    (tmp_path / "c").touch()
    for bad in (tmp_path / "b", tmp_path / "c" / "d"):
        with pytest.raises(ConfigError, match="cannot write") as caught:
            write_files({tmp_path / "a": b"new", bad: b"new"})
        assert caught.value.code == "output-unwritable"
        assert (tmp_path / "a").read_bytes() == b"old"
        assert names(tmp_path) == ["a", "b", "c"]


@posix
def test_a_full_device_undoes_the_files(tmp_path: Path) -> None:
    if not Path("/dev/full").is_char_device():
        pytest.skip("there is no /dev/full here")
    full = tmp_path / "full"
    full.symlink_to("/dev/full")
    (tmp_path / "a").write_bytes(b"old")
    with pytest.raises(ConfigError, match="No space left"):
        write_files({full: b"new", tmp_path / "a": b"new"})
    assert (tmp_path / "a").read_bytes() == b"old"
    assert names(tmp_path) == ["a", "full"]


@posix
def test_a_file_that_may_not_be_written_to(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "a"
    file.write_bytes(b"old")
    file.chmod(0o444)
    monkeypatch.setattr(os, "access", lambda *_: False)  # as root, all may be
    with pytest.raises(ConfigError, match="Permission denied"):
        write_files({file: b"new"})
    assert file.read_bytes() == b"old"


def test_data_is_on_disk_before_it_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[str] = []
    replace = Path.replace
    monkeypatch.setattr(os, "fsync", lambda _: done.append("sync"))
    monkeypatch.setattr(
        Path, "replace", lambda self, to: done.append("rename") or replace(self, to)
    )
    monkeypatch.setattr(output, "_sync_folder", lambda _: done.append("folder"))
    write_files({tmp_path / "a.py": b"1", tmp_path / "b.py": b"2"})
    assert done == ["sync", "sync", "rename", "rename", "folder"]
