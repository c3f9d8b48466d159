"""What is claimed of workers: measured on this machine, and carried on to more of them by a model."""
