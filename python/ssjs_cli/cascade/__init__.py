"""Haar cascades from labelled images to detections: files in, models, tables and pictures out. The methods themselves are in the core."""
