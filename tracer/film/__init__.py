"""From samples to means, variances and a picture through any reconstruction filter."""
