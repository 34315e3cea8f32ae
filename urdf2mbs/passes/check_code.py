"""Check code: that the code just made does what the URDF says.

Beyond the method.  The project's Python is loaded into the runtime of ``simulate``, and called at
random states: forces in joints, followers, contacts, wrenches, springs, sensors, the start, and the
equations of motion where the project has them.  What they should give is computed by a second route
(``urdf2mbs/laws``).  A project that differs is not written, and its ``.mbs`` is marked as
rejected.  C takes longer to compile than all else takes: ``verify --code`` compares it.
"""

from __future__ import annotations

from urdf2mbs.conversion import Conversion
from urdf2mbs.engine.hookspecs import Pass

#: The folders of a project that hold code.
FOLDERS = ("userfctR", "symbolicR")


class CheckCode(Pass):
    reads = ("mbs-file",)

    def run(self, conversion: Conversion) -> None:
        proof, output, files = conversion.proof, conversion.settings.output, conversion.files
        if conversion.settings.project is None or proof is None or output not in files:
            return
        if "c" in conversion.settings.languages:
            proof.not_compared["the code in C"] = "'verify --code' compares it"
        if "python" in conversion.settings.languages:
            from urdf2mbs.runtime.code import prove_code

            prove_code(conversion, proof, code_of(conversion, ".py"))
        if not proof.same:
            conversion.rejected = output.with_suffix(f".rejected{output.suffix}")
            files[conversion.rejected] = files.pop(output)
            for path in [path for path in files if path.parent.name in FOLDERS]:
                del files[path]
            conversion.starters.clear()
            conversion.obsolete.clear()


def code_of(conversion: Conversion, *endings: str) -> dict[str, bytes]:
    """The model and the code of a project, by their paths in it."""
    output, project = conversion.settings.output, conversion.settings.project
    assert project is not None
    return {
        path.relative_to(project).as_posix(): data
        for path, data in {**conversion.starters, **conversion.files}.items()
        if path == output or (path.parent.name in FOLDERS and path.suffix in endings)
    }
