"""Checks of values, files, and the contents of networks and problems."""
