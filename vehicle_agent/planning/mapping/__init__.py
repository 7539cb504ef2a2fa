"""Planning of maps from landmarks over a thin link (Kapoutsis 2015)."""
