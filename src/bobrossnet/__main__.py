"""`python -m bobrossnet`: the command."""

import sys

from bobrossnet.command_line.cli import main

if __name__ == "__main__":
    sys.exit(main())
