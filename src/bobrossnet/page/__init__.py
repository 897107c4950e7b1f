"""The viewer's page and what else its code becomes: served, in a folder, in one file, for npm, in notebooks."""
