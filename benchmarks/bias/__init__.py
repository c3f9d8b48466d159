"""How far the mean of adaptive pictures is off."""
