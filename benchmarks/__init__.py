"""Speed, as ratios against a peer in the same run. ``make bench`` prints them all."""

import os

# As the program itself starts: see solarcal.__main__.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
