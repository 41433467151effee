"""Missions of a down-looking camera."""
