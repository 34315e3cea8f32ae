"""The second route of the tests: what a robot and the code of its project should do.

It shares no line with what it judges.  ``mbs`` and ``urdf`` read the two files themselves;
``multibody`` has Newton and Euler's laws, ``pin`` Pinocchio; ``compare`` sets a conversion beside a
model of its URDF.  ``mjcf`` writes an .mbs with its loops for MuJoCo.  ``generated`` runs equations
in Python and C, beside a stand-in for Robotran's data.  ``code`` calls a whole project at random
states, and compares it with the laws: ``joints``, ``followers``, ``ground``, ``forces``,
``sensors``, ``start``, ``equations``.
"""
