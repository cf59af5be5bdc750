"""Learns from reports what nobody has said: noise, clutter, detection, speed, turns."""
