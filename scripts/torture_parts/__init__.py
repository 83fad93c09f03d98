"""Parts of scripts/torture: each attacks the program in one way and says what went wrong."""
