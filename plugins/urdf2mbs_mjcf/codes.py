"""MJCF: what MuJoCo cannot read, what a URDF cannot say, and where the two programs differ."""

CODES = {
    "mjcf-file": "error: an MJCF names a file outside of its folder, its workspace and the "
    "packages. Name its folder under `packages`, or give `--trust-xacro`.",
    "mjcf-invalid": "error: MuJoCo does not read the file. Correct the line that is named.",
    "mjcf-too-large": "error: MuJoCo takes too long for the file, or too much memory. Make it "
    "smaller.",
    "mjcf-crash": "error: MuJoCo has crashed on the file. Correct the file.",
    "mjcf-tendon": "warning: tendons are left out, but for those between two sites that an "
    "equality keeps at their length. Write their forces in the project's code.",
    "mjcf-actuator": "warning: actuators that are no motor of one joint are left out. Write their "
    "forces in the project's code.",
    "mjcf-soft-body": "warning: flexible bodies (flex) are left out. Model them by rigid ones.",
    "mjcf-shape": "warning: geoms are left out that no URDF has: ellipsoids, fields, meshes "
    "without a file. Replace them; their mass is there.",
    "mjcf-coupling": "warning: equalities are left out. Write them as user constraints of the "
    "project.",
    "mjcf-mocap": "warning: bodies that a user moves (mocap) stand still, and nothing is tied to "
    "them. Move them in the project's code.",
    "mjcf-law": "warning: laws of joints, bodies and actuators are left out. Write their forces in "
    "the project's code.",
    "mjcf-fluid": "warning: forces of a fluid are left out. Write them in the project's code.",
    "mjcf-limit": "warning: limits, springs, damping, friction and armature of ball and free "
    "joints are left out. Write their forces in the project's code.",
    "mjcf-contact": "warning: pairs of contact are left out. Add the ground to a project: "
    "`passes: {contacts: ...}`.",
    "mjcf-start": "warning: velocities of keyframes are left out. Set them in the project's code.",
    "mjcf-sensor": "warning: sensors are left out that are no accelerometer and no gyro on a site. "
    "Read joints and bodies in the project's code.",
    "mjcf-flag": "warning: flags of an MJCF switch off what the .mbs has. Leave it out of the "
    "project, too.",
    "mjcf-plugin": "warning: plugins of MuJoCo are left out. Write their forces in the project's "
    "code.",
    "mjcf-soft": "note: limits, friction and equalities are soft in MuJoCo, and stiff here",
    "mjcf-frame": "note: the frame of a link is at its last joint, not at the frame of the body",
}
