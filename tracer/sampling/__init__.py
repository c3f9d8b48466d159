"""From a list of (pixel, sample index) to radiance, in passes that fill the device."""
