"""The report's figures, drawn from data: one file each, all in one style."""
