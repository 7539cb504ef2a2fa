"""The radio of a fleet over Zenoh: one wrapper for agents, stations, the simulator and referees; public."""
