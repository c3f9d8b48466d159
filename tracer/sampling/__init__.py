"""From a list of (pixel, sample index) to radiance, in passes large enough to occupy the device."""
