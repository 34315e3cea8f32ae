"""Settings, plugins, and the files that are written."""

CODES = {
    "plugin-idle": "warning: no pass of a plugin is in the pipeline. Name its pass in the "
    "config, or leave the plugin out.",
    "plugin-summary": "warning: a plugin failed to say what it did; only its lines are left out. "
    "Correct the plugin.",
    "unknown-preset": "error: there is no such preset. Correct the name.",
    "preset-circle": "error: presets extend each other in a circle. Remove one `extends`.",
    "unknown-code": "error: the level of this code cannot be set. Correct the name.",
    "unknown-pass": "error: there is no such pass, or it is not in the pipeline. Correct the name.",
    "unknown-plugin": "error: the plugin in `swap` does not bring the pass. Correct the name.",
    "pass-doubled": "error: a pass is in the pipeline twice. Remove one.",
    "pass-ambiguous": "error: two plugins bring a pass of one name. Choose by `swap`.",
    "need-not-given": "error: a pass reads a section that no pass writes. Add a pass.",
    "wrong-order": "error: a pass reads a section that a later pass writes. Exchange the two.",
    "stale": "error: a pass changes the source of an earlier result. Move the pass.",
    "undeclared": "warning: a pass changes a section that is not in its `writes`. Add it there.",
    "plugin-verdict": "error: a plugin changes settings or a result of `check`. Correct it.",
    "package-missing": "error: `packages` names a folder that does not exist. Correct the path.",
    "output-is-source": "error: the output would replace the robot. Name another output.",
    "output-is-folder": "error: the output is a folder. Name a file.",
    "output-not-ours": "error: the output was edited, or is not ours. Give `--force`.",
    "output-unwritable": "error: a file cannot be written; none was. Make the folder writable.",
    "project-in-source": "error: the project would be in the robot's folder. Name another.",
    "sweep-many": "error: the config makes many robots, and the command wants one. Use `run`.",
    "plugin-missing": "error: a plugin, or the file of a plugin, is not there. Correct the path.",
    "plugin-broken": "error: the plugin cannot be loaded. Correct it, or give `--no-plugins`.",
    "plugin-empty": "error: the plugin has no function marked `@hookimpl`. Mark one.",
    "plugin-doubled": "error: two plugins have one name. Rename one.",
    "plugin-failed": "error: a plugin's pass or hook has failed. See `--debug`.",
    "plugin-robot-broken": "error: a plugin's pass leaves no tree of links. Correct the pass.",
    "plugin-output-broken": "error: a plugin leaves files that nobody can write. Correct it.",
    "robot-settings": "note: settings that the robot's own file states. Set them in the config to "
    "overrule them.",
    "robot-settings-invalid": "error: the reader of a file returns settings that no config has. "
    "Correct the plugin.",
    "internal": "error: urdf2mbs has failed. Please report it.",
}
