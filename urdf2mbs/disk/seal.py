"""The seal: the checksum of a file, in a comment on its last line.

Only a file whose seal is intact is replaced without ``force``: nobody has changed it since
urdf2mbs wrote it.  Line ends do not count, because git may convert them.  A kind of file that
has no comments is recorded beside it instead (``RECORD``), and so are the user's own files as they
were first.
"""

from __future__ import annotations

import re
from pathlib import Path

#: The file with the checksums of those files of its folder that hold no seal (``sha256sum``).
RECORD = ".urdf2mbs"
#: What stands around a comment, by the ending of a file; of XML and HTML see ``_comment``.
_COMMENTS = {
    **dict.fromkeys((".py", ".yaml", ".yml", ".wrl"), ("# ", "")),
    **dict.fromkeys((".c", ".h"), ("/* ", " */")),
}
_WORDS = "sealed by urdf2mbs: sha256 "
_SEAL = re.compile(rb"(<!-- |# |/\* )" + _WORDS.encode() + rb"([0-9a-f]{64})( -->| \*/|)\s*\Z")
#: The longest last line that can be a seal.
_LONGEST = 120


def seal(path: Path, data: bytes) -> bytes:
    """The file with its seal; as it is where it has one, or where ``path`` has no comments."""
    around = _comment(path, data)
    if around is None or not data or intact(data):
        return data
    data = unseal(data)
    if not data.endswith(b"\n"):
        data += b"\n"
    return data + f"{around[0]}{_WORDS}{checksum(data)}{around[1]}\n".encode()


def unseal(data: bytes) -> bytes:
    """The file without its seal."""
    start = _last_line(data)
    return data[:start] if _SEAL.match(data, start) else data


def can_hold(path: Path, data: bytes) -> bool:
    """True if a file has comments, so that it can hold a seal."""
    return _comment(path, data) is not None


def has_seal(data: bytes) -> bool:
    """True if there is a seal, of this text or of another text."""
    return _WORDS.encode() in data


def intact(data: bytes) -> bool:
    """True if the last line is the seal of this very text."""
    start = _last_line(data)
    found = _SEAL.match(data, start)
    return found is not None and found[2].decode() == checksum(data[:start])


def checksum(data: bytes) -> str:
    """The sha256 of a text, its lines ended by a line feed."""
    from hashlib import sha256  # its library takes as long to load as all our passes

    return sha256(data.replace(b"\r\n", b"\n") if b"\r" in data else data).hexdigest()


def _last_line(data: bytes) -> int:
    """Where the last line begins that is not empty; the end, where this is too long for a seal."""
    end = len(data) - len(data[-_LONGEST:]) + len(data[-_LONGEST:].rstrip())
    start = data.rfind(b"\n", max(0, end - _LONGEST), end) + 1
    return start or len(data)


def _comment(path: Path, data: bytes) -> tuple[str, str] | None:
    if data.startswith(b"<"):  # XML of any name: nothing may stand before its first line
        return "<!-- ", " -->"
    return _COMMENTS.get(path.suffix.lower())
