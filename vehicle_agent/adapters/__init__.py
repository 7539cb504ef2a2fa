"""The world behind the ports: MAVLink autopilots, Zenoh, files."""
