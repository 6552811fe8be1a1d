"""What the project needs on a machine: the script that installs it, the versions it pins, a check of it."""
