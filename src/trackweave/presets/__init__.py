"""What the three source documents prescribe, one readable page each."""
