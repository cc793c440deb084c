"""Pages of this machine for the person at it: the loopback address, and the guard in front of a page."""
