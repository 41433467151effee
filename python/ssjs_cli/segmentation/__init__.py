"""Sonar segmentation over many images: files in, masks, regions and pictures out. The method itself is in the core."""
