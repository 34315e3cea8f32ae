"""Many robots: several configs, a folder of robots, or a sweep, on all cores or on a cluster."""

from urdf2mbs.plugin import hookimpl


@hookimpl
def urdf2mbs_api() -> dict[str, str]:
    package = "urdf2mbs_many"
    return {
        "Outcome": f"{package}.job:Outcome",
        "convert_many": f"{package}.convert:convert_many",
        "carry_out_folder": f"{package}.commands.many:carry_out_folder",
        "carry_out_many": f"{package}.commands.many:carry_out_many",
        "sweep": f"{package}.sweep",
    }


@hookimpl
def urdf2mbs_codes() -> dict[str, str]:
    from urdf2mbs_many.codes import CODES

    return CODES
