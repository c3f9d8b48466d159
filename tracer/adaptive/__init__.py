"""Decisions alone: which pixels get the samples of the next round, and when there are enough samples."""
