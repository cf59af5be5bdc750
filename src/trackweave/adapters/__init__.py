"""Other libraries' objects in and out; each module needs its library."""
