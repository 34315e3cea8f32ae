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
from typing import Any

import msgspec

from urdf2mbs.plugin import ConfigError, ConversionError
from urdf2mbs_simulate.equations import HEADERS, INCLUDES, cache_folder, keep
from urdf2mbs_simulate.names import describe_add_on

HERE = Path(__file__).parent
#: Equations of 2025 and later call ``user_call_X``: here ``run_X`` of ``turn.c``, which calls
#: ``user_X``.
FLAGS = (
    "-std=gnu99",
    "-O2",
    "-w",
    *(
        f"-Duser_call_{name}=run_{name}"
        for name in (
            "ExtForces",
            "Link3DForces",
            "LinkForces",
            "DrivenJoints",
            "cons_hJ",
            "cons_jdqd",
        )
    ),
)
SHARED = ("-fPIC", "-fno-semantic-interposition")
#: How many files are compiled at a time.
AT_A_TIME = 2


class Source(msgspec.Struct, frozen=True):
    """A file of C, the folders of its headers, and the macros that it is compiled with."""

    file: Path
    folders: tuple[Path, ...]
    defines: tuple[str, ...] = ()


class _Texts:
    """The bytes of files, and of the headers that they include, read once."""

    def __init__(self) -> None:
        self.texts: dict[Path, bytes | None] = {}
        self.names: dict[Path, list[str]] = {}

    def read(self, file: Path) -> bytes | None:
        """Return the bytes of a file; None if there is none."""
        if file not in self.texts:
            self.texts[file] = file.read_bytes() if file.is_file() else None
        return self.texts[file]

    def includes(self, file: Path) -> list[str]:
        if file not in self.names:
            self.names[file] = list(map(bytes.decode, INCLUDES.findall(self.read(file) or b"")))
        return self.names[file]

    def read_with_headers(self, source: Source) -> list[bytes]:
        """Return the bytes of a file and of all headers that it includes from its folders."""
        found, waiting = {source.file: self.read(source.file) or b""}, [source.file]
        while waiting:
            file = waiting.pop()
            for name in self.includes(file):
                for folder in (file.parent, *source.folders):
                    header = folder / name
                    text = self.read(header)
                    if text is not None:
                        if header not in found:
                            found[header] = text
                            waiting.append(header)
                        break
        return list(found.values())


@cache
def compiler() -> str | None:
    """Return the C compiler: ``$CC``, else cc, gcc or clang, else zig of the package ziglang, which
    the extra ``live`` brings; None if there is none."""
    names = [os.environ["CC"]] if os.environ.get("CC") else ["cc", "gcc", "clang"]
    return next(filter(None, [*map(shutil.which, names), zig()]), None)


def zig() -> str | None:
    """Return the compiler of the package ziglang, which compiles for a page, too."""
    package = find_spec("ziglang")
    folders = package.submodule_search_locations if package else None
    return shutil.which("zig", path=folders[0]) if folders else None


def require_compiler() -> str:
    """Return the C compiler.

    Raises:
        ConfigError: There is none.
    """
    found = compiler()
    if found is None:
        message = "no C compiler: neither cc nor gcc nor clang nor ziglang"
        raise ConfigError("usage", message, hint="pip install ziglang")
    return found


def compile_library(
    sources: Sequence[Source], on_compile: Callable[[int, int], None] | None = None
) -> Any:
    """Compile files of C, and load the library.

    Raises:
        ConversionError: A file does not compile.
    """
    command = require_compiler()
    # zig compiles for the processor that it runs on, and machines may share the cache
    portable = ["-mcpu=baseline"] * (Path(command).stem == "zig")
    build = Build(command, [*SHARED, *portable], ["-shared", *portable], ".so", on_compile)
    return ctypes.CDLL(str(build.make(sources)))


class Build:
    """Compiles and links with one compiler; what was made before is taken from the cache."""

    def __init__(
        self,
        compiler: str,
        compile_flags: Sequence[str],
        link_flags: Sequence[str],
        suffix: str,
        on_compile: Callable[[int, int], None] | None = None,
    ) -> None:
        self.compiler, self.suffix = compiler, suffix
        self.compile_flags, self.link_flags = compile_flags, link_flags
        self.on_compile = on_compile or (lambda done, total: None)

    @cached_property
    def command(self) -> list[str]:
        return [self.compiler, "cc"] if Path(self.compiler).stem == "zig" else [self.compiler]

    def make(self, sources: Sequence[Source]) -> Path:
        """Compile and link files; return what was made, a file of the cache."""
        texts = _Texts()
        objects = [self._object_of(source, texts) for source in sources]
        key = self._key([file.name.encode() for file in objects], self.link_flags)
        made = cache_folder() / "libraries" / f"{key}{self.suffix}"
        if not made.is_file():
            self._compile_missing(sources, objects)
            self._run([*self.link_flags, *map(str, objects), "-lm"], made)
        return made

    def _object_of(self, source: Source, texts: _Texts) -> Path:
        """Return the object of a file, which may not be there yet."""
        words = [*FLAGS, *self.compile_flags, *source.defines]
        key = self._key([source.file.name.encode(), *texts.read_with_headers(source)], words)
        return cache_folder() / "objects" / f"{key}.o"

    def _key(self, texts: Iterable[bytes], words: Sequence[str]) -> str:
        key = sha256(" ".join([self.compiler, platform.machine(), *words]).encode())
        for text in texts:
            key.update(b"\0" + text)
        return key.hexdigest()[:32]

    def _compile_missing(self, sources: Sequence[Source], objects: Sequence[Path]) -> None:
        missing = {
            file: source
            for source, file in zip(sources, objects, strict=True)
            if not file.is_file()
        }
        # the longest first: nothing then waits for one that was begun last
        order = sorted(missing.items(), key=lambda item: -item[1].file.stat().st_size)
        with ThreadPoolExecutor(AT_A_TIME) as pool:
            runs = [pool.submit(self._compile, source, file) for file, source in order]
            try:
                for done, run in enumerate(runs):
                    self.on_compile(done, len(runs))
                    run.result()
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise

    def _compile(self, source: Source, made: Path) -> None:
        folders = [f"-I{folder}" for folder in source.folders]
        words = [*FLAGS, *self.compile_flags, *source.defines, *folders]
        self._run([*words, "-c", str(source.file)], made)

    def _run(self, words: Sequence[str], made: Path) -> None:
        """Let the compiler make a file of the cache."""
        with tempfile.TemporaryDirectory(prefix="urdf2mbs-") as folder:
            file = Path(folder, made.name)
            done = subprocess.run(
                [*self.command, *words, "-o", str(file)],
                check=False,
                capture_output=True,
                text=True,
                encoding="utf-8",
                errors="replace",
            )
            if done.returncode:
                raise _not_compiled(done.stderr)
            keep(made, file.read_bytes())


def folders_of(user_path: Path, symbolic_path: Path) -> tuple[Path, ...]:
    """Return the folders of headers of a project: those of the runtime first."""
    return (HERE, HEADERS, user_path, symbolic_path)


def _not_compiled(text: str) -> ConversionError:
    """Return the compiler's first error, with its file and line."""
    found = re.search(r"(?m)^(.+?):(\d+):(?:\d+:)? (?:fatal )?error: (.*)$", text)
    if found is None:
        return ConversionError("not-compiled", f"the C compiler says: {text.strip()[-500:]}")
    hint = None
    if header := re.match(r"'?([\w./]+\.h)'?(: No such file| file not found)", found[3]):
        hint = describe_add_on(header[1])
        if hint is None and header[1].lower().startswith("mbs"):
            hint = "it is of Robotran's MBsysC, of which this runtime has a part"
    return ConversionError("not-compiled", found[3], file=found[1], line=int(found[2]), hint=hint)
