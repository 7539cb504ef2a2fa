"""The kinds of vehicles: how each takes off or dives, steers, returns and comes to rest."""
