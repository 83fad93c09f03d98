"""Parts of scripts/render."""
