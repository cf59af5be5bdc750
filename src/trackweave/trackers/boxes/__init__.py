"""Boxes of a detector, frame by frame: the same object keeps its name."""
