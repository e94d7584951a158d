"""Outlines, colours and drawing of grains."""
