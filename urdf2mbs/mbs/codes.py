"""Reading an ``.mbs``."""

CODES = {
    "not-mbs": "error: the root is not `mbsDescR7`. Take an `.mbs`.",
    "mbs-incomplete": "error: an element is missing that Robotran needs. Add it.",
    "body-without-joint": "error: a body has no joint; Robotran would drop it. Add a joint.",
    "parent-missing": "error: a body has no parent. Name the parent.",
    "parent-unknown": "error: the parent of a body does not exist. Correct the name.",
    "parent-order": "error: the parent of a body comes later in the file. Move the parent up.",
    "point-unknown": "error: an anchor point does not exist. Correct the name.",
    "name-unknown": "error: a plugin's cut, link or constraint names nothing. Correct it.",
    "joint-unknown": "error: a user constraint names no joint. Correct the name.",
    "joint-nature-unknown": "error: a joint's nature is unknown to Robotran. Write `independent`.",
    "value-unknown": "error: a measure of a sensor is not `true`. Write `true`.",
    "mbs-not-first": "error: a name or `coordinates` is not the first child. Move it up.",
    "mbs-not-plain": "error: a name contains a comment or an element. Remove it.",
    "origin-moved": "error: a point called `origin` is not at 0 0 0. Rename it.",
    "base-sensor": "error: a sensor or an external force is on the base. Move it to a body.",
}
