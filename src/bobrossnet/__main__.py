"""`python -m bobrossnet`: the command."""

import sys

from bobrossnet.command_line.cli import main

sys.exit(main())
