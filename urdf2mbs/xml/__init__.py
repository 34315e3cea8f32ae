"""XML texts: line numbers beyond libxml2's, and what is wrong with a text that is no XML."""
