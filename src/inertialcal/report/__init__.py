"""The report: figures, and one page that holds a whole campaign. Alone imports matplotlib."""

import logging

# What matplotlib logs (no folder for its cache, a font it lacks) reaches those who ask for logs, not standard error.
logging.getLogger("matplotlib").addHandler(logging.NullHandler())
