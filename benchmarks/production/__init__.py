"""All that is claimed of production features, measured: noise targets, overheads, denoising."""
