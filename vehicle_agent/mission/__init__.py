"""The mission file: its types, its reading and its errors; public."""
