"""Numpy and the modules that need it are imported by one thread at a time.

Numpy's modules import each other in a circle. Two threads that begin at once can each wait for a
module the other has half made; Python then hands out the half, the import fails, and numpy cannot
be imported a second time in the process. Nothing of it is imported before the first paint, so that
the first threads, and the first key, would begin at once.
"""

import threading

ONE_IMPORT = threading.RLock()
"""Held by whoever imports a module that needs numpy, on whichever thread."""
