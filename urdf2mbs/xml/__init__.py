"""XML texts: a parser, and what is wrong with a text that is no XML."""
