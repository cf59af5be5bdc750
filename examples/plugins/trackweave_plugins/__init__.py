"""Models for trackweave that are not its own."""
