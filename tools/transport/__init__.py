"""Tables of carried particles: fates by class of diameter, and what two-way coupling changes."""
