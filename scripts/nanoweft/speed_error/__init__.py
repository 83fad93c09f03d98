"""Parts of scripts/speed_error."""
