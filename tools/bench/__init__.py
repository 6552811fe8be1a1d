"""Error against CPU time of the whole suite and its peers, scaling, and what is skipped.

    python -m tools.bench                  # make bench: 30 to 50 minutes
    python -m tools.bench --quick          # make bench QUICK=1: at most 5 minutes

flow.py, scenes.py, transport.py: what runs, one job a program and resolution;
scaling.py: cost of a step and memory; skip.py: scenes that do not use a feature against the
program without it; processes.py and partitions.py: runs on several processes, and a model of more; rounds.py runs the jobs
interleaved; page.py and figure.py write the page.
"""
