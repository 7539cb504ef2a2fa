"""The operator's picture of a fleet: a reducer over what is heard, a terminal dashboard and a plain line log."""
