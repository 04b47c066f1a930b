"""`python -m app` is the `relight` command."""

import sys

from app.cli.main import main

sys.exit(main())
