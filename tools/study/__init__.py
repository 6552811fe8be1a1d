"""Refinement studies: runs over sizes and steps, orders, limits and their uncertainty, reports and figures."""
