"""Numbers and geometry of the field, without I/O; a public leaf that every package may import."""
