"""Several pictures of one scene file, by frames and sensors."""
