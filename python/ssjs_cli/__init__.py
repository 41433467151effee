"""Submap joining SLAM on the command line: missions in, trajectories, maps and reports out. The estimation itself is `ssjs_cli._core`."""
