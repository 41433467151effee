"""Missions with the frames of a down-looking camera."""
