"""What is reported and what is believed, as plain values."""
