"""The presets that are there: the plugin of ``compact`` may be away."""

from contextlib import suppress

PRESETS = ["faithful"]
with suppress(ModuleNotFoundError):
    import urdf2mbs_compact

    PRESETS += urdf2mbs_compact.urdf2mbs_presets()
