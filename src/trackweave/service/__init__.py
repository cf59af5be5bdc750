"""The live service: what comes in is stored before it is acted on, and what it says follows."""
