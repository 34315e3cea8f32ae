"""The reference of the tests: what a robot, and the code of its project, should do.

No module here imports urdf2mbs when it runs, and a test holds this.  ``mbs``, ``urdf`` and
``stated`` read the two files themselves; ``multibody`` has Newton and Euler's laws, ``pin``
Pinocchio.  ``mjcf`` writes an .mbs with its loops for MuJoCo.  ``generated`` runs equations in
Python and C, beside a stand-in for Robotran's data.  The laws of a project's code are in
``joints``, ``followers``, ``ground``, ``forces``, ``sensors``, ``start`` and ``equations``; each
compares what the code does in a ``case`` with what the URDF and the config ask for.

Beside this package, ``support.compare`` sets a conversion next to its URDF, and
``support.project_code`` loads the code of a project and asks each law about it.
"""
