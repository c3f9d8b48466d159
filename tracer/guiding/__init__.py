"""What rays have learned about lights, per cell of space: which light is worth a shadow ray from where."""
