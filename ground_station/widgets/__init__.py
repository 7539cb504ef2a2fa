"""Widgets that draw lines made by `ground_station.views` and hold no state of the fleet."""
