"""Numbers that others published, measured anew: what scenes under runs/ and tests share."""
