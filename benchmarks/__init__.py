"""Speed as ratios against a peer in the same run (``make bench``), and studies of how good the
answers are (``make bench-judgement``)."""

import os

# As the program itself starts: see solarcal.__main__.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
