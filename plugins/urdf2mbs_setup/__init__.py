"""What helps to set up and to write plugins: versions, schema, completion, new passes, dumps."""

from urdf2mbs.plugin import Command, hookimpl


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    sentences = {
        "explain": "show the passes of a config, or every known pass, without running them",
        "new-pass": "write a plugin with one pass, and its test",
        "schema": "print the JSON schema of a config, for editors",
        "doctor": "show versions, extras, plugins, ROS packages and Robotran as they are here",
        "completion": "print a script that completes commands and options in a shell",
    }
    return [
        Command(name, does, f"urdf2mbs_setup.commands.{name.replace('-', '_')}")
        for name, does in sentences.items()
    ]


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    return {"Dump": "urdf2mbs_setup.dump:Dump"}


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_setup.codes import CODES

    return CODES
