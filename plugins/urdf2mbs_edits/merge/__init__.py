"""Convert again, and keep what was edited: three models become one."""
