"""Pictures as lines of coloured text: pure functions from a `FleetState` and a size, drawn by whoever has a screen."""
