"""Side-scan logs: what they hold, and their picture."""
