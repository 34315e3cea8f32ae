"""xacro in a process of its own, with an empty environment and limits on time and memory.

xacro is code: a macro that calls itself, or an expression such as ``${'a' * 10**10}``, can run
without an end or fill the memory.  Here that ends in an error.  This is no sandbox: the process
reads any file that its user may read, and an expression that finds a way out of xacro's own checks
can do whatever that user can.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from math import ceil
from pathlib import Path
from threading import Timer

import msgspec

from urdf2mbs.diagnostics import ConfigError, ConversionError, Diagnostic
from urdf2mbs.stopping import Unfinished
from urdf2mbs.urdf.limits import Isolate
from urdf2mbs.urdf.packages import Packages
from urdf2mbs.urdf.xacro import Expansion, expand

#: What the process runs: ``urdf2mbs`` may be found by a path that an empty environment has not.
_START = (
    "import sys; sys.path[:] = sys.argv[1:]; from urdf2mbs.urdf.isolated import answer; answer()"
)


class _Question(msgspec.Struct):
    source: str
    packages: dict[str, str]
    args: dict[str, str]
    seconds: float
    memory: int | None


class _Answer(msgspec.Struct):
    """What xacro made, or what is wrong."""

    text: bytes = b""
    files: list[str] = []
    said: list[Diagnostic] = []
    error: Diagnostic | None = None
    exit_code: int = 0
    memory_full: bool = False


def isolated(source: Path, packages: Packages, args: dict[str, str], limits: Isolate) -> Expansion:
    """``xacro.expand`` in a process of its own.

    :raises ConversionError: its codes, and ``xacro-isolated``
    :raises ConfigError: ``isolate-unsupported``
    """
    memory = limits.bytes()
    if memory is not None and sys.platform == "win32":
        raise ConfigError(
            "isolate-unsupported", "isolate: the memory of a process cannot be limited on Windows",
            hint="write 'memory: null', and only the time is limited",
        )  # fmt: skip
    question = _Question(
        str(packages.source), {name: str(folder) for name, folder in packages.table.items()},
        {name: str(value) for name, value in args.items()}, limits.seconds, memory,
    )  # fmt: skip
    with Unfinished():
        late, code, data = _ask(msgspec.msgpack.encode(question), limits)
    answer = None
    with suppress(msgspec.MsgspecError):
        answer = msgspec.msgpack.decode(data, type=_Answer)
    if late or answer is None or answer.memory_full:
        raise ConversionError(
            "xacro-isolated",
            f"xacro was stopped: it took more than {limits.seconds:g} seconds"
            if late
            else f"xacro was stopped: it took more than {limits.memory} of memory"
            if answer is not None
            else f"xacro's process ended without an answer (exit code {code}): it crashed, or took "
            "more time or memory than it has",
            file=str(source),
            hint="look for macros that call themselves and for long loops; or give it more: "
            "'expand: {isolate: {seconds: ..., memory: ...}}'",
        )
    if answer.error is not None:
        one = answer.error
        kind = ConfigError if answer.exit_code == ConfigError.exit_code else ConversionError
        error = kind(one.code, one.message, file=one.file, line=one.line, hint=one.hint)
        error.said = answer.said
        raise error
    return Expansion(answer.text, answer.files, answer.said)


def _ask(question: bytes, limits: Isolate) -> tuple[bool, int, bytes]:
    """Whether the process was late, its exit code, and what it answered."""
    # Windows starts no process without this one
    environment = {name: os.environ[name] for name in ("SYSTEMROOT",) if name in os.environ}
    process = subprocess.Popen(
        [sys.executable, "-I", "-c", _START, *map(os.path.abspath, sys.path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        env=environment, start_new_session=True,
    )  # fmt: skip
    assert process.stdin is not None
    assert process.stdout is not None
    late = False

    def stop() -> None:
        with suppress(OSError):
            if sys.platform == "win32":
                process.kill()
            else:
                os.killpg(process.pid, signal.SIGKILL)

    def stop_late() -> None:
        nonlocal late
        late = True
        stop()

    timer = Timer(limits.seconds, stop_late)
    timer.start()
    try:
        with suppress(OSError), process.stdin:
            process.stdin.write(question)
        data = process.stdout.read(-1 if (most := limits.bytes()) is None else most)
        return late, process.poll() or 0, data
    finally:
        timer.cancel()
        stop()
        process.stdout.close()
        process.wait()


def answer() -> None:
    """What the process does: read a question, limit itself, expand, answer."""
    question = msgspec.msgpack.decode(sys.stdin.buffer.read(), type=_Question)
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # nothing that an expression prints is part of the answer
    _limit(question)
    source = Path(question.source)
    packages = Packages({name: Path(folder) for name, folder in question.packages.items()}, source)
    try:
        made = expand(source, packages, question.args)
        answer = _Answer(made.text, made.files, made.warnings)
    except ConversionError as error:
        answer = _Answer(
            said=error.said, error=error.diagnostic(), exit_code=error.exit_code,
            memory_full=_memory_full(error),
        )  # fmt: skip
    except MemoryError:
        answer = _Answer(memory_full=True)
    with out:
        out.write(msgspec.msgpack.encode(answer))


def _limit(question: _Question) -> None:
    try:
        import resource
    except ImportError:  # Windows
        return
    seconds = ceil(question.seconds) + 1
    limits = [(resource.RLIMIT_CPU, seconds), (resource.RLIMIT_CORE, 0), (resource.RLIMIT_FSIZE, 0)]
    if question.memory is not None:
        limits.append((resource.RLIMIT_AS, question.memory))
    for kind, most in limits:
        with suppress(OSError, ValueError):  # more than this user may have is no limit
            resource.setrlimit(kind, (most, most))


def _memory_full(error: BaseException | None) -> bool:
    while error is not None:
        if isinstance(error, MemoryError):
            return True
        error = error.__cause__ or error.__context__
    return False
