"""The autopilots that the simulator can be: one file of quirks each."""
