"""Many robots."""

CODES = {
    "output-doubled": "error: two robots have one output",
    "folder-empty": "error: there is no robot in the folder",
    "sweep-empty": "error: a sweep, or a list in it, has no values",
    "sweep-long": "error: a sweep makes more than a million robots",
    "sweep-output": "error: a sweep has no output, or the output names an unknown value",
    "sweep-range": "error: a range is incomplete, or its steps do not end at `to`",
    "sweep-twice": "error: a value is given and swept",
    "cluster-unreachable": "error: no Dask scheduler answers at the address",
    "cluster-failed": "error: the workers of the cluster cannot convert",
    "worker-died": "error: the system ended the process of a robot twice",
}
