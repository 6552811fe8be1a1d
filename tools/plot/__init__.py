"""Pictures and films of runs: resolved ones, contacts alone, steady flows, carried particles."""
