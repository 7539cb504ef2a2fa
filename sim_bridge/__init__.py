"""A fleet's bodies and their world, seen by others only through MAVLink and the payload topic."""
