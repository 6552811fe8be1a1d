"""Many runs: a run repeated from its folder, sweeps over parameters and seeds."""
