"""Convert again and keep the edits: three models become one."""
