"""C compilers: files become objects, which are cached one by one, and objects a library."""

from __future__ import annotations

import ctypes
import os
import platform
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache, cached_property
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from urdf2mbs.plugin import ConfigError, ConversionError
from urdf2mbs_simulate.equations import HEADERS, INCLUDES, get_cache_folder, write_to_cache
from urdf2mbs_simulate.names import describe_add_on

HERE = Path(__file__).parent
#: User functions that equations of 2025 and later call by the name ``user_call_X``.
USER_CALLS = ("ExtForces", "Link3DForces", "LinkForces", "DrivenJoints", "cons_hJ", "cons_jdqd")
#: ``user_call_X`` becomes ``run_X`` of ``turn.c``, which calls ``user_X``.
FLAGS = ("-std=gnu99", "-O2", "-w", *(f"-Duser_call_{name}=run_{name}" for name in USER_CALLS))
SHARED = ("-fPIC", "-fno-semantic-interposition")
#: How many files are compiled at the same time.
N_PROCESSES = 2

#: Called with the numbers of compiled files and of all files.
OnCompile = Callable[[int, int], None]


class Source(msgspec.Struct, frozen=True):
    """A file of C, the folders of its headers, and the macros that it is compiled with."""

    file: Path
    folders: tuple[Path, ...]
    defines: tuple[str, ...] = ()


class _SourceReader:
    """Reads files and the headers that they include, each of them once."""

    def __init__(self) -> None:
        self.texts: dict[Path, bytes | None] = {}
        self.includes: dict[Path, list[str]] = {}

    def read(self, file: Path) -> bytes | None:
        """Return the bytes of a file; None if it does not exist."""
        if file not in self.texts:
            self.texts[file] = file.read_bytes() if file.is_file() else None
        return self.texts[file]

    def list_includes(self, file: Path) -> list[str]:
        """Return the names of the headers that a file includes."""
        if file not in self.includes:
            names = INCLUDES.findall(self.read(file) or b"")
            self.includes[file] = list(map(bytes.decode, names))
        return self.includes[file]

    def find_header(self, name: str, folders: Iterable[Path]) -> Path | None:
        """Return the first header of a name in the folders, or None."""
        return next(
            (folder / name for folder in folders if self.read(folder / name) is not None), None
        )

    def read_with_headers(self, source: Source) -> list[bytes]:
        """Return the bytes of a file and of all headers that it includes from its folders."""
        texts, unread = {source.file: self.read(source.file) or b""}, [source.file]
        while unread:
            file = unread.pop()
            for name in self.list_includes(file):
                header = self.find_header(name, (file.parent, *source.folders))
                if header is not None and header not in texts:
                    texts[header] = self.read(header) or b""
                    unread.append(header)
        return list(texts.values())


@cache
def compiler() -> str | None:
    """Return the path of the C compiler.

    It is ``$CC``, else cc, gcc or clang, else zig of the package ziglang, else None.
    """
    names = [os.environ["CC"]] if os.environ.get("CC") else ["cc", "gcc", "clang"]
    return next(filter(None, [*map(shutil.which, names), find_zig()]), None)


def find_zig() -> str | None:
    """Return the compiler of the package ziglang, which compiles for a page, too."""
    package = find_spec("ziglang")
    folders = package.submodule_search_locations if package else None
    return shutil.which("zig", path=folders[0]) if folders else None


def require_compiler() -> str:
    """Return the path of the C compiler.

    Raises:
        ConfigError: No compiler is installed.
    """
    path = compiler()
    if path is None:
        message = "no C compiler: neither cc nor gcc nor clang nor ziglang"
        raise ConfigError("usage", message, hint="pip install ziglang")
    return path


def compile_library(sources: Sequence[Source], on_compile: OnCompile | None = None) -> Any:
    """Compile files of C, and load the library.

    Raises:
        ConversionError: A file does not compile.
    """
    compiler_path = require_compiler()
    # zig compiles for the processor that it runs on, and machines may share the cache
    portable = ["-mcpu=baseline"] * (Path(compiler_path).stem == "zig")
    flags = BuildFlags([*SHARED, *portable], ["-shared", *portable], ".so")
    return ctypes.CDLL(str(Build(compiler_path, flags, on_compile).make(sources)))


class BuildFlags(NamedTuple):
    """The options of a compiler for one kind of output."""

    compile: Sequence[str]
    link: Sequence[str]
    suffix: str
    """Of the linked file."""


class Build:
    """Compiles and links with one compiler; files that were made before are in the cache."""

    def __init__(
        self, compiler_path: str, flags: BuildFlags, on_compile: OnCompile | None = None
    ) -> None:
        self.compiler_path, self.flags = compiler_path, flags
        self.on_compile = on_compile or (lambda done, total: None)

    @cached_property
    def command(self) -> list[str]:
        """The words that begin a call of the compiler."""
        is_zig = Path(self.compiler_path).stem == "zig"
        return [self.compiler_path, "cc"] if is_zig else [self.compiler_path]

    def make(self, sources: Sequence[Source]) -> Path:
        """Compile and link files.

        Returns:
            The linked file, in the cache.

        Raises:
            ConversionError: A file does not compile.
        """
        reader = _SourceReader()
        objects = [self._locate_object(source, reader) for source in sources]
        key = self._hash([file.name.encode() for file in objects], self.flags.link)
        linked = get_cache_folder() / "libraries" / f"{key}{self.flags.suffix}"
        if not linked.is_file():
            self._compile_missing(sources, objects)
            self._run([*self.flags.link, *map(str, objects), "-lm"], linked)
        return linked

    def _locate_object(self, source: Source, reader: _SourceReader) -> Path:
        """Return the path of the object of a file, which may not exist yet."""
        words = [*FLAGS, *self.flags.compile, *source.defines]
        key = self._hash([source.file.name.encode(), *reader.read_with_headers(source)], words)
        return get_cache_folder() / "objects" / f"{key}.o"

    def _hash(self, texts: Iterable[bytes], words: Sequence[str]) -> str:
        """Return the name in the cache of what the compiler makes of texts with options."""
        key = sha256(" ".join([self.compiler_path, platform.machine(), *words]).encode())
        for text in texts:
            key.update(b"\0" + text)
        return key.hexdigest()[:32]

    def _compile_missing(self, sources: Sequence[Source], objects: Sequence[Path]) -> None:
        """Compile the files whose objects do not exist."""
        missing = {
            file: source
            for source, file in zip(sources, objects, strict=True)
            if not file.is_file()
        }
        # the longest first: no process then waits for one that was started last
        order = sorted(missing.items(), key=lambda item: -item[1].file.stat().st_size)
        with ThreadPoolExecutor(N_PROCESSES) as pool:
            tasks = [pool.submit(self._compile, source, file) for file, source in order]
            try:
                for done, task in enumerate(tasks):
                    self.on_compile(done, len(tasks))
                    task.result()
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise

    def _compile(self, source: Source, output: Path) -> None:
        folders = [f"-I{folder}" for folder in source.folders]
        words = [*FLAGS, *self.flags.compile, *source.defines, *folders]
        self._run([*words, "-c", str(source.file)], output)

    def _run(self, words: Sequence[str], output: Path) -> None:
        """Let the compiler make a file of the cache."""
        with tempfile.TemporaryDirectory(prefix="urdf2mbs-") as folder:
            file = Path(folder, output.name)
            process = subprocess.run(
                [*self.command, *words, "-o", str(file)],
                check=False,
                capture_output=True,
                text=True,
                encoding="utf-8",
                errors="replace",
            )
            if process.returncode:
                raise _make_compile_error(process.stderr)
            write_to_cache(output, file.read_bytes())


def list_header_folders(user_path: Path, symbolic_path: Path) -> tuple[Path, ...]:
    """Return the folders of headers of a project: those of the runtime first."""
    return (HERE, HEADERS, user_path, symbolic_path)


def _make_compile_error(stderr: str) -> ConversionError:
    """Return the compiler's first error, with its file and line."""
    match = re.search(r"(?m)^(.+?):(\d+):(?:\d+:)? (?:fatal )?error: (.*)$", stderr)
    if match is None:
        return ConversionError("not-compiled", f"the C compiler says: {stderr.strip()[-500:]}")
    hint = None
    if header := re.match(r"'?([\w./]+\.h)'?(: No such file| file not found)", match[3]):
        hint = describe_add_on(header[1])
        if hint is None and header[1].lower().startswith("mbs"):
            hint = "it belongs to Robotran's MBsysC, of which this runtime has a part"
    line = int(match[2])
    return ConversionError("not-compiled", match[3], file=match[1], line=line, hint=hint)
