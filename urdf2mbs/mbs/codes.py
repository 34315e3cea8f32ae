"""Reading an ``.mbs``."""

CODES = {
    "not-mbs": "error: the root is not `mbsDescR7`",
    "mbs-incomplete": "error: an element is missing that Robotran needs",
    "body-without-joint": "error: a body has no joint; Robotran would lose it",
    "parent-missing": "error: a body has no parent",
    "parent-unknown": "error: the parent of a body does not exist",
    "parent-order": "error: the parent of a body stands later in the file",
    "point-unknown": "error: an anchor point does not exist",
    "name-unknown": "error: a plugin's cut, link or user constraint names nothing in the model",
    "joint-unknown": "error: a user constraint names a joint that does not exist",
    "joint-nature-unknown": "error: a joint is not `independent`, `dependent` or `driven`",
    "value-unknown": "error: a measure of a sensor is not `true`",
    "mbs-not-first": "error: a name or `coordinates` is not the first child; Robotran reads zeros",
    "mbs-not-plain": "error: a comment or an element stands in a name",
    "origin-moved": "error: a point called `origin` is not at 0 0 0",
    "base-sensor": "error: a sensor or an external force is on the base",
}
