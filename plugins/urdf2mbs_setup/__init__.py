"""What helps to set up: versions that are here, a schema for editors, completion for shells."""

from urdf2mbs.plugin import Command, hookimpl


@hookimpl
def urdf2mbs_commands() -> list[Command]:
    sentences = {
        "schema": "print the JSON schema of a config, for editors",
        "doctor": "show versions, extras, plugins, ROS packages and Robotran as they are here",
        "completion": "print a script that completes commands and options in a shell",
    }
    return [
        Command(name, does, f"urdf2mbs_setup.commands.{name}") for name, does in sentences.items()
    ]
