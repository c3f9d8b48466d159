"""One render under way: the loop of rounds, its state, checkpoints, and what is kept of it at the end."""
