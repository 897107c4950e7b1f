"""The command `bobrossnet`: its subcommands, their arguments, how it starts and ends."""
