"""What is made of a picture when its samples are drawn."""
