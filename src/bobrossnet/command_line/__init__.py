"""The command `bobrossnet`: its subcommands, their arguments, its start and its end."""
