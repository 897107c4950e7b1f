"""The viewer's page in all its forms: served, in a folder, in one file, on npm, in notebooks."""
