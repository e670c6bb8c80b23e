"""`python -m plumbob`: the same as the command `plumbob`."""

import sys

from plumbob.reports.cli import main

sys.exit(main())
