"""How far a run is: what its files say while they grow (progress.py), and how that is shown (show.py)."""
