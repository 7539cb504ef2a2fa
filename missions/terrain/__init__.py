"""Small terrain files of the missions, and the program that makes them from survey data."""
