"""The commands, a file each: its options, what it does, what it prints.

Help lists the commands without importing them.
"""

#: In the order of the help.
COMMANDS = {
    "init": "write a config for a robot, to start from",
    "run": "convert as a config file says, or as several do",
    "convert": "convert one robot, or a folder of them, without a config file",
    "report": "convert, and write one HTML page to look at instead",
    "verify": "compare a robot with an .mbs file: are they the same?",
    "diagram": "draw the 2D diagram of an .mbs file as an SVG picture",
    "equations": "write Robotran's equations for an .mbs file",
    "explain": "show the passes of a config, without running them",
    "passes": "list every known pass",
    "new-pass": "write a plugin with one pass, and its test",
    "schema": "print the JSON schema of a config, for editors",
    "doctor": "show versions, extras, plugins, ROS packages and Robotran as they are here",
    "completion": "print a script that completes commands and options in a shell",
}
