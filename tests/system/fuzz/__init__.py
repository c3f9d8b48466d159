"""Thousands of broken scenes, meshes, pictures and checkpoints, each a right result or one sentence."""
