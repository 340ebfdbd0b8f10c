"""`python -m lidardraft` is the `lidardraft` command."""

import sys

from lidardraft.cli.main import main

if __name__ == "__main__":  # worker processes import this file under another name
    sys.exit(main())
