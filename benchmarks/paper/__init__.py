"""The radiosity of the paper as it is published, beside classical random rays, a lattice and ours."""
