"""Give broken files to every command that reads one, guided by the lines of code that they reach.

    pip install -e '.[fuzz]'
    python tests/fuzz.py --minutes 60 [--only mbs --only stl]

``broken.py`` says what a finding is.  Each is printed once; its input is in build/fuzz.  A short
input goes into tests/corpus/KIND once it is mended.  More than 3 GB, or 2 minutes, end the fuzzer.
"""

import argparse
import os
import random
import re
import sys
import tempfile
import traceback
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

import atheris

with atheris.instrument_imports(include=["urdf2mbs", "xacro"]):
    import urdf2mbs

    for module in walk_packages(urdf2mbs.__path__, "urdf2mbs."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    from support.broken import CORPUS, KINDS, attempt, files_of, prepare

TOKEN = re.compile(rb'"[^"\n]*"|<[^<>]*>|[-+\w.]+|[<>{}\[\]:,]')
WORDS = [*(CORPUS / "words").read_bytes().splitlines(), b"", b"\0", b"[" * 300, b"<a>" * 300]


def slip(data: bytes, chance: random.Random) -> bytes:
    """A word, a string or a tag is replaced, doubled or dropped."""
    tokens = [*TOKEN.finditer(data)]
    if not tokens:
        return data
    token, other = chance.choice(tokens), chance.choice(tokens)[0]
    new = chance.choice(WORDS)
    quoted = b'"' + new + b'"' if token[0].startswith(b'"') else new
    new = chance.choice([new, quoted, other, token[0] + other, b""])
    return data[: token.start()] + new + data[token.end() :]


def stay_in(*folders: Path) -> None:
    """From now on nothing outside these folders can be written, and there is no network."""

    def refuse(event: str, words: tuple[Any, ...]) -> None:
        writes = event == "open" and words[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        if writes or event in ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.link"):
            place = os.fsdecode(words[0]) if isinstance(words[0], (str, bytes)) else os.devnull
            known = Path(place).resolve() == Path(os.devnull)
            if not known and not any(Path(place).resolve().is_relative_to(f) for f in folders):
                raise PermissionError(13, "Permission denied", place)
        elif event in ("socket.connect", "subprocess.Popen"):
            raise PermissionError(13, "Permission denied")

    sys.addaudithook(refuse)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--only", action="append", choices=KINDS)
    asked = parser.parse_args()
    findings = Path("build/fuzz").resolve()
    grown = findings / "grown"
    grown.mkdir(parents=True, exist_ok=True)
    kinds = asked.only or [*KINDS]
    seen: set[str] = set()

    def mutate(data: bytes, limit: int, seed: int) -> bytes:
        chance, text = random.Random(seed), data[1:]
        for _ in range(chance.choice([1, 1, 2, 4])):
            text = slip(text, chance) if chance.random() < 0.6 else atheris.Mutate(text, limit - 1)
        return (data[:1] + text)[:limit]

    def run(data: bytes) -> None:
        kind = [*KINDS][data[0] % len(KINDS)] if data else ""
        if kind not in kinds:
            return
        try:
            attempt(kind, data[1:])
        except Exception as error:
            root = error.__cause__ or error
            place = traceback.extract_tb(root.__traceback__)[-1]
            what = f"{kind}: {type(root).__name__}, {place.filename}:{place.lineno}"
            if what not in seen:
                seen.add(what)
                file = findings / f"{kind}-{len(seen)}"
                file.write_bytes(data[1:])
                print(f"{what}: {str(root)[:500]} ({file})", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder, "a", "b")  # '../..' is still in the folder
        work.mkdir(parents=True)
        os.chdir(work)
        tempfile.tempdir = folder
        os.environ["XDG_CACHE_HOME"] = str(work / "cache")
        prepare()
        for kind in kinds:
            for file in files_of(kind):
                head = bytes([[*KINDS].index(kind)])  # the first byte of an input is its kind
                (grown / f"{kind}-{file.name}").write_bytes(head + file.read_bytes())
        stay_in(Path(folder), findings)
        limits = [f"-max_total_time={60 * asked.minutes:.0f}", "-timeout=120", "-rss_limit_mb=3000"]
        options = ["-max_len=40000", "-len_control=0", f"-artifact_prefix={findings}/", str(grown)]
        atheris.Setup([sys.argv[0], *limits, *options], run, custom_mutator=mutate)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
