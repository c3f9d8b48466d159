"""Decisions, and nothing else: who gets the samples of the next round, and when there are enough."""
