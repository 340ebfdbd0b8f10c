"""Puts `planned` on the path of the tests below."""
