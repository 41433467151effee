"""A finished run as one MCAP file, for viewers with a time slider (Foxglove, Lichtblick)."""
