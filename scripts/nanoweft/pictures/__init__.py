"""Tubes as pictures and movies, tables as plots."""
