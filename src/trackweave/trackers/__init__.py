"""From scans to tracks, scan by scan."""
