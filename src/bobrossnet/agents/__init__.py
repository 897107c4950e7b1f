"""Eyes for programs that design parts: a server of the Model Context Protocol."""
