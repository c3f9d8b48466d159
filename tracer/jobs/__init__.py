"""Jobs: all pictures to be rendered of one scene file, by frames and sensors."""
