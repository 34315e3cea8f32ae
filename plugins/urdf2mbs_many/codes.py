"""Many robots."""

CODES = {
    "output-doubled": "error: two robots have the same output. Give each its own.",
    "folder-empty": "error: the folder contains no robot. Name another folder.",
    "sweep-empty": "error: a sweep, or a list in it, has no values. Give values.",
    "sweep-long": "error: a sweep makes more than a million robots. Give fewer values.",
    "sweep-output": "error: a sweep has no output, or the output names an unknown value. "
    "Name all values in the output.",
    "sweep-range": "error: a range is incomplete, or its steps do not end at `to`. "
    "Correct `from`, `to` or the steps.",
    "sweep-twice": "error: a value is given and swept. Remove one of the two.",
    "cluster-unreachable": "error: no Dask scheduler answers at the address. "
    "Start a scheduler, or correct the address.",
    "cluster-failed": "error: the workers of the cluster cannot convert. "
    "Install urdf2mbs on the workers.",
    "worker-died": "error: the system ended the process of a robot twice. "
    "Convert the robot alone, with more memory.",
}
