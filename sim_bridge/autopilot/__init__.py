"""A simulated MAVLink 2 autopilot without I/O: bytes in, bytes out, one file per microservice."""
